"""Systems: a circuit with its values, read from a file."""
