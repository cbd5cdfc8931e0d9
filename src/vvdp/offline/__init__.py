"""Angle and speed from measured logs: edges, the event filter over them, what a record reports itself."""
