"""Periodic steady states of switched circuits, quasi-steady averages, and a system on a test rig."""
