"""The library of components that networks are made of."""
