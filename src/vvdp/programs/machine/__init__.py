"""The control of a whole machine as one program: stages, laws, supervision, and what it adds to the results."""
