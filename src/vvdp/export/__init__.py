"""Export of systems in the forms that other programs read."""
