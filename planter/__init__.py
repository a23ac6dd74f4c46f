"""Planting-machine mechanisms, from the printed equation to the optimum.

This package is the numeric part: it reads machine files, evaluates the generated equations of motion and
optimises designs. Nothing heavy is imported here.
"""

from planter.version import __version__

__all__ = ["__version__"]
