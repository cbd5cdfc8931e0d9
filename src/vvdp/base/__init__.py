"""Checked values with units and sources, and the few operations that every formula may use."""
