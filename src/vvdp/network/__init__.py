"""Networks: nodes and components that write the circuit a person would have written."""
