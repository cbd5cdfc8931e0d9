"""A local page in the browser: a circuit, its values and its curves, which follow while a value is dragged."""
