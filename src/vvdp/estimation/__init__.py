"""Angle and speed from the edges of a coarse encoder, and from the inlet pressure."""
