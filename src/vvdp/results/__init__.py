"""What every study of vvdp leaves: one kind of result, on disk and back, as numbers, tables and figures as data."""
