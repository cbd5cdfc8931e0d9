"""Results of every study of vvdp: one kind, on disk and back, as numbers, tables and figures as data."""
