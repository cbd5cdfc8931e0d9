"""Baseline estimators: known methods without a model of faults, and one with a model of the torques."""
