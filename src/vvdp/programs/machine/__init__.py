"""The control of a whole machine as one program: stages, laws, supervision, and its results."""
