"""Holding the spool's axial position: references, control laws of both drives, what they store, how they are tuned."""
