"""CasADi's scalar operations as C text. Truth values are 1.0 and 0.0, as CasADi has them.

A select prints as `c != 0.0 ? a : 0.0`, never as `c * a`: 0 times an infinity would be no number. Logic is arithmetic
of ones and zeros, because compilers turn chains of selects between truth values into masks that they cannot vectorise.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca


@dataclass(frozen=True)
class Operation:
    """A C expression with its arguments, names or constants, as {0}, {1}.

    `truth`: its value is 1.0 or 0.0; `logical`: so must its arguments be.
    """

    text: str
    arguments: int
    truth: bool = False
    logical: bool = False


def _call(name: str, arguments: int = 1) -> Operation:
    return Operation(f"{name}({', '.join(f'{{{i}}}' for i in range(arguments))})", arguments)


def _compared(sign: str) -> Operation:
    return Operation(f"{{0}} {sign} {{1}} ? 1.0 : 0.0", 2, truth=True)


def _logical(text: str, arguments: int) -> Operation:
    return Operation(text, arguments, truth=True, logical=True)


OPERATIONS: dict[int, Operation] = {
    ca.OP_ADD: Operation("{0} + {1}", 2),
    ca.OP_SUB: Operation("{0} - {1}", 2),
    ca.OP_MUL: Operation("{0} * {1}", 2),
    ca.OP_DIV: Operation("{0} / {1}", 2),
    ca.OP_NEG: Operation("-{0}", 1),
    ca.OP_INV: Operation("1.0 / {0}", 1),
    ca.OP_SQ: Operation("{0} * {0}", 1),
    ca.OP_TWICE: Operation("2.0 * {0}", 1),
    ca.OP_SIGN: Operation("({0} > 0.0 ? 1.0 : 0.0) - ({0} < 0.0 ? 1.0 : 0.0)", 1),
    ca.OP_LT: _compared("<"),
    ca.OP_LE: _compared("<="),
    ca.OP_EQ: _compared("=="),
    ca.OP_NE: _compared("!="),
    ca.OP_NOT: _logical("1.0 - {0}", 1),
    ca.OP_AND: _logical("{0} * {1}", 2),
    ca.OP_OR: _logical("{0} + {1} - {0} * {1}", 2),
    ca.OP_IF_ELSE_ZERO: Operation("{0} != 0.0 ? {1} : 0.0", 2),
    ca.OP_SIN: _call("turned_sin"),
    ca.OP_COS: _call("turned_cos"),
    ca.OP_SQRT: _call("sqrt"),
    ca.OP_FABS: _call("fabs"),
    ca.OP_FLOOR: _call("whole_floor"),
    ca.OP_CEIL: _call("ceil"),
    ca.OP_FMIN: _call("fmin", 2),
    ca.OP_FMAX: _call("fmax", 2),
    ca.OP_COPYSIGN: _call("copysign", 2),
    ca.OP_EXP: _call("exp"),
    ca.OP_LOG: _call("log"),
    ca.OP_POW: _call("pow", 2),
    ca.OP_CONSTPOW: _call("pow", 2),
    ca.OP_TAN: _call("tan"),
    ca.OP_ASIN: _call("asin"),
    ca.OP_ACOS: _call("acos"),
    ca.OP_ATAN: _call("atan"),
    ca.OP_ATAN2: _call("atan2", 2),
    ca.OP_SINH: _call("sinh"),
    ca.OP_COSH: _call("cosh"),
    ca.OP_TANH: _call("tanh"),
    ca.OP_ASINH: _call("asinh"),
    ca.OP_ACOSH: _call("acosh"),
    ca.OP_ATANH: _call("atanh"),
    ca.OP_LOG1P: _call("log1p"),
    ca.OP_EXPM1: _call("expm1"),
    ca.OP_HYPOT: _call("hypot", 2),
    ca.OP_ERF: _call("erf"),
    ca.OP_FMOD: _call("fmod", 2),
}
"""What can be printed, by CasADi's number of the operation."""
