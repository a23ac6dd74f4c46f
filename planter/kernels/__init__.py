"""Compiled functions behind exact names and shapes: the strict call layer, the ways to evaluate,
what was generated.
"""

from planter.kernels.backends import Array, Flags, Integers
from planter.kernels.kernel import BoundKernel, CallError, Kernel

__all__ = ["Array", "BoundKernel", "CallError", "Flags", "Integers", "Kernel"]
