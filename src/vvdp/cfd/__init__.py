"""Computational fluid dynamics of the valve: cases for OpenFOAM from its shape, their runs, and their results."""
