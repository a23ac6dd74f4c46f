"""Printed numbers of the clutch's paper, and the formulas that recompute them."""
