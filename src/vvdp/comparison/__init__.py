"""Estimators against a known truth: scenarios, trials on many random seeds, scores."""
