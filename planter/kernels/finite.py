"""Whether arrays that stay where they are hold finite numbers, in a microsecond where something can be compiled."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from functools import partial
from importlib import resources

import numpy as np

from planter.kernels import toolchain
from planter.kernels.toolchain import NoCompiler
from planter.kernels.work import Array


def watch(arrays: Sequence[Array]) -> Callable[[], int]:
    """Says at each call which of some contiguous arrays, from 1, is the first that is not finite; 0 if all are.

    Who calls it keeps the arrays.
    """
    try:
        look = _compiled()
    except NoCompiler:
        return partial(_first, arrays)
    places = (ctypes.c_void_p * len(arrays))(*(array.ctypes.data for array in arrays))
    sizes = (ctypes.c_long * len(arrays))(*(array.size for array in arrays))
    return partial(look, ctypes.c_long(len(arrays)), places, sizes)


def _compiled() -> Callable[..., int]:
    source = resources.files(__package__).joinpath("finite.c").read_text(encoding="utf-8")
    look: Callable[..., int]
    (look,) = toolchain.functions(toolchain.library("finite", source, toolchain.OPTIMISED), "not_finite")
    return look


def _first(arrays: Sequence[Array]) -> int:
    return next((number for number, array in enumerate(arrays, 1) if not np.isfinite(array).all()), 0)
