"""Chapter 1: what is claimed of digital hydraulics and of on/off valves."""
