"""Estimators that others are measured by: known methods without a model of faults, and one that knows the torques."""
