"""Solids, fluid domains and unwrapped surfaces of the rotary valve, from the parameters of its hydraulic model."""
