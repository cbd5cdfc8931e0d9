"""Evaluation of a run of a system: numbers with their kinds, validity, ranges, closed forms, and the test rig."""
