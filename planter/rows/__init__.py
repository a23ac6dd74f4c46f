"""Rows of outputs: sweeps over plans, tolerances by Monte Carlo, robust designs."""
