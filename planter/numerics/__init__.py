"""Numerical methods that know neither machine nor optimiser."""
