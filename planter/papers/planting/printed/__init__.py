"""Printed numbers of the planting device's paper, and the formulas that recompute them."""
