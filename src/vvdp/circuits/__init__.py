"""Wiring of components: each circuit is one function from state and command to rates and outputs."""
