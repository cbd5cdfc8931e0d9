"""Studies: many cases of one system, run in batches on all cores, kept on disk and resumed."""
