"""Numerical methods that know no hydraulics."""
