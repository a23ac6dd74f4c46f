"""Numerical methods that depend on neither machines nor the optimiser."""
