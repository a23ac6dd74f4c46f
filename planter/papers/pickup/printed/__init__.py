"""Printed numbers of the pick-up's paper, and the formulas that recompute them."""
