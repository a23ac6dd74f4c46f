"""Compiled functions behind exact names and shapes: the strict call layer, the ways to evaluate,
what was generated.
"""

from planter.kernels.kernel import Array, BoundKernel, CallError, Kernel

__all__ = ["Array", "BoundKernel", "CallError", "Kernel"]
