"""What the rotary valve competes with: circuits with other valves and pumps, and what is claimed against them."""
