"""Sampled programs that a system file names: controllers, filters, references, estimators."""
