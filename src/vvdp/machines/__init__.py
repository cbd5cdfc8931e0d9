"""Circuits that functions draw: benches of the rotary valve, its axial drives, cylinders in displacement control."""
