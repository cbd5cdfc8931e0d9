"""The report of a run: a page that can be printed, made from a result directory alone."""
