"""What the run of a system gives: numbers with their kinds, validity, ranges, closed forms, and the test rig."""
