"""Planting-machine mechanisms, from the printed equation to the optimum.

This package is the numeric part: it reads machine files, evaluates the generated equations of motion and
optimises designs. Nothing heavy is imported here.
"""

__version__ = "0.1.0"
