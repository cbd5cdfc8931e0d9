"""Chapter 3: angle and speed of the spool from a coarse encoder."""
