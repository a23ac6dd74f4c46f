"""Modules of array code: the same steps for NumPy, JAX, mpmath and complex step."""

from __future__ import annotations

from collections.abc import Sequence

from ...model import Formulas, System
from ...quantity import OpenVector
from ..expression import ARRAY
from ..text import Emitted
from .casadi import NOTICE

COMPOSED = """ `stage1` and `stage2` are contact
functions of pitch curves, (xp, t, parameters, hoisted) -> (r, dr, ddr, ratio, dratio, turned)."""


def system_module(system: System | Formulas, functions: Sequence[Emitted]) -> str:
    """The text of a module with one function per stage."""
    texts = "\n\n\n".join(_function(f, system) for f in functions)
    return f'''"""{system.title}: array code.

{NOTICE}
`xp` is a module of elementary functions under NumPy's names: numpy, jax.numpy, or a few lines around mpmath. Packed
inputs are indexed along their first axis, so an entry may itself be an array.{COMPOSED if system.callables else ""}
"""


{texts}
'''


def _function(function: Emitted, system: System | Formulas) -> str:
    composed = any(isinstance(v, OpenVector) for v in function.inputs)
    stages = "".join(f", {c}" for c in system.callables) if composed else ""
    return f'''def {function.name}(xp, {function.names()}{stages}):
    """{function.output.name}: {len(function.output)} entries in the order of the CasADi function."""
{function.body(ARRAY)}
    return (
{function.packed(ARRAY)},
    )'''
