"""Contact ratio of rack teeth on pitch curves, by their curvatures."""

from __future__ import annotations

from planter.kernels import formulas

TEETH = formulas.load("gear_teeth")
"""Functions of teeth at the curvatures of two pitch curves; `teeth`: module, addenda in modules, pressure angle."""
