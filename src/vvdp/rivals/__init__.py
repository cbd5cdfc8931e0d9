"""Rivals of the rotary valve: circuits with other valves and pumps, and claims that compare them with it."""
