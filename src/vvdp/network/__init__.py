"""Networks: circuits as graphs of nodes and components."""
