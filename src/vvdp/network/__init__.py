"""Networks: nodes and components that write the circuit a user would have written."""
