"""Chapter 2: pressure drop, torque and speed of the rotary valve, and its inlet rail."""
