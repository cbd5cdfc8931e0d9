"""Virtual test rigs: steady maps, pressure drop, ripple, step and frequency response."""
