"""Measured logs: files of data acquisition read as channels, each with its own unit and its own clock."""
