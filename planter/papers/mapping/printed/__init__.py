"""Printed numbers of the patent on kinematic mapping, and the formulas that recompute them."""
