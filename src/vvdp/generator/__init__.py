"""Machine code and readable text from plain Python functions: a typed tree, its verifier and its writers."""
