"""Displacement control of a cylinder: chapter 6 as written, and the whole machine."""
