"""The working fluid: oil with free air, its density, viscosity, compressibility and the energy it stores."""
