"""The printer, node by node: text in both dialects, evaluated, against mpmath."""

import casadi
import mpmath
import numpy as np
import pytest
import sympy as sp

from derive.emit import expression
from derive.emit.expression import Printer, UnsupportedNode, count_operations
from derive.emit.targets.array import ARRAY
from derive.emit.targets.casadi import CASADI
from derive.functions import Polynomial, TabulatedFunction, Turns, clip, switch, wrap

x, y, z = sp.symbols("x y z", real=True)
PIECES = ((-2.0, (1.0, -0.5, 3.0)), (0.2, (0.3, 1.0, -1.0)), (0.7, (-1.0, 2.0, 0.5)))
OPEN_TABLE = type("open_table", (TabulatedFunction,), {"pieces": PIECES})
BOUNDED_TABLE = type(
    "bounded_table", (TabulatedFunction,), {"pieces": PIECES, "limits": (-2.0, 2.0)}
)
NODES = {
    "symbol": x,
    "integer": x + 7,
    "negative integer": x * -3,
    "rational": sp.Rational(1, 3) + x,
    "rational factor": sp.Rational(-2, 7) * x * y,
    "float": sp.Float("0.1234567890123456789", 20) * x,
    "pi": sp.pi / 9 + x,
    "sum": x - y + z - 2,
    "product": x * y / z,
    "quotient of sums": (x - y) / (z * (x + 2)),
    "negative of a sum": -(x - y) * z,
    "nested minus": x - (y - (z - x)),
    "square": (x + y) ** 2,
    "inverse": 1 / x,
    "inverse square": 1 / (x + y) ** 2,
    "root": sp.sqrt(x + 2),
    "inverse root": 1 / sp.sqrt(x + 2),
    "three halves": (x + 2) ** sp.Rational(3, 2),
    "minus three halves": (x + 2) ** sp.Rational(-3, 2),
    "decimal three halves": (x + 2) ** 1.5,
    "minus five halves, decimal": (x + 2) ** -2.5,
    "decimal square": sp.cos(x) ** 2.0,
    "decimal one": sp.Mul(y, sp.Pow(x, 1.0, evaluate=False), evaluate=False),
    "decimal root": (x + 2) ** 0.5,
    "third": (x + 2) ** sp.Rational(1, 3),
    "decimal third": (x + 2) ** (-1 / 3),
    "any decimal": (x + 2) ** 0.123456789,
    "power of a number": 2.0 ** sp.cos(x),
    "power of a sum": -((x + 2) ** (y - z)),
    "cos": sp.cos(x),
    "sin": sp.sin(x * y),
    "tan": sp.tan(x),
    "acos": sp.acos(x / 10),
    "asin": sp.asin(x / 10),
    "atan": sp.atan(x),
    "atan2": sp.atan2(x, -y),
    "exp": sp.exp(-x),
    "log": sp.log(x + 3),
    "abs": sp.Abs(x - y),
    "sign": sp.sign(x - y),
    "floor": sp.floor(10 * x),
    "turns": Turns(-7 * x / 2),
    "polynomial": Polynomial(x * y, 2, -3, 0, sp.Rational(1, 4)),
    "table": OPEN_TABLE(x - y),
    "table with limits": x / BOUNDED_TABLE(z),
    "min": sp.Min(x, y, z),
    "max": sp.Max(x, y, z),
    "switch": switch(x - y, x**2, y / 3),
    "clip": clip(x, y, z),
    "wrap": wrap(-10 * x, 2 * sp.pi),
    "and": sp.Piecewise((x, sp.And(x > 0, y < 0)), (z, True)),
    "or": sp.Piecewise((x, sp.Or(x < y, z < 0)), (z, True)),
    "not": sp.Piecewise((x, sp.Not(sp.And(x > 0, y > 0), evaluate=False)), (z, True)),
    "greater or equal": sp.Piecewise((x, sp.Ge(x, y)), (y, True)),
    "less or equal": sp.Piecewise((x, sp.Le(x, y)), (y, True)),
    "three cases": sp.Piecewise((x, x < y), (y, y < z), (z, True)),
}
POINTS = [(0.3, 1.7, 0.9), (1.9, -0.4, 0.2), (0.6, 0.5, -1.1)]
NUMPY = {"xp": np, "x": 0.0, "y": 0.0, "z": 0.0}


def exact(expr: sp.Expr, point: tuple[float, float, float]) -> float:
    at = dict(zip((x, y, z), map(sp.Float, point), strict=True))
    with mpmath.workdps(40):
        return float(expr.xreplace(at).rewrite(sp.floor).evalf(30))


def by_casadi(text: str, point: tuple[float, float, float]) -> float:
    symbols = [casadi.SX.sym(n) for n in "xyz"]
    value = eval(text, vars(casadi) | dict(zip("xyz", symbols, strict=True)))
    return float(casadi.Function("f", symbols, [value])(*point))


@pytest.mark.parametrize("point", POINTS)
@pytest.mark.parametrize("name", NODES)
def test_both_dialects_equal_mpmath(name: str, point: tuple[float, float, float]) -> None:
    expr = NODES[name]
    expected = exact(expr, point)
    by_array = eval(Printer(ARRAY)(expr), {"xp": np} | dict(zip("xyz", point, strict=True)))
    assert by_casadi(Printer(CASADI)(expr), point) == pytest.approx(expected, rel=4e-15, abs=4e-15)
    assert float(by_array) == pytest.approx(expected, rel=4e-15, abs=4e-15)


def test_every_supported_node_is_tested() -> None:
    used = {
        kind
        for expr in NODES.values()
        for part in sp.preorder_traversal(expr)
        for kind in type(part).__mro__
    }
    untested = {kind.__name__ for kind in expression.TABLE} - {kind.__name__ for kind in used}
    assert untested <= {"Equality", "Unequality", "Greater", "StrictGreaterThan", "Not"}


@pytest.mark.parametrize("expr", [sp.gamma(x), sp.Derivative(sp.Function("f")(x), x), sp.I * x])
def test_other_nodes_are_refused_by_name(expr: sp.Expr) -> None:
    with pytest.raises(UnsupportedNode, match="cannot be written"):
        Printer(CASADI)(expr)


def test_refusal_names_no_common_subexpression() -> None:
    with pytest.raises(
        UnsupportedNode, match=r"^Heaviside cannot be written: .*Piecewise"
    ) as error:
        Printer(CASADI)(y * sp.Heaviside(sp.Symbol("c17")))
    assert "c17" not in str(error.value)


def test_decimal_powers_are_the_fractions_they_stand_for() -> None:
    for decimal, fraction in (
        (1.5, sp.Rational(3, 2)),
        (1 / 3, sp.Rational(1, 3)),
        (-0.75, sp.Rational(-3, 4)),
    ):
        assert Printer(CASADI)((x + 2) ** decimal) == Printer(CASADI)((x + 2) ** fraction)
    assert Printer(CASADI)((x + 2) ** 0.12345) != Printer(CASADI)((x + 2) ** 0.12346)


def test_cases_without_an_otherwise_are_refused() -> None:
    with pytest.raises(UnsupportedNode, match="otherwise"):
        Printer(CASADI)(sp.Piecewise((x, x > 0)))


def test_constants_have_all_their_digits() -> None:
    third = sp.Float("0.33333333333333333333", 25)
    assert float(Printer(CASADI)(third)) == 1 / 3
    assert eval(Printer(ARRAY)(sp.Rational(1, 3)), {"xp": np}) == 1 / 3


def test_no_case_is_multiplied() -> None:
    """A select must not evaluate as flag times value: 0 times infinity is no number."""
    text = Printer(CASADI)(switch(x, 1 / x, y))
    assert text.startswith("if_else(")
    assert by_casadi(text, (-1.0, 2.0, 0.0)) == 2.0


def test_table_is_undefined_beyond_limits() -> None:
    point = 4.4, 0.0, 0.0
    assert by_casadi(Printer(CASADI)(OPEN_TABLE(x)), point) == pytest.approx(
        -(3.7**2) + 2 * 3.7 + 0.5, rel=1e-14
    )
    assert np.isnan(by_casadi(Printer(CASADI)(BOUNDED_TABLE(x)), point))


def test_derivatives_of_turns_and_wrap() -> None:
    assert sp.diff(Turns(x), x) == 0
    assert sp.diff(wrap(x, 2 * sp.pi), x) == 1


COUNTS = [
    (x + y + z, 2),
    (x * y, 1),
    (sp.sin(x) + 1, 2),
    (switch(x, y, z), 2),
    (switch(x + y, y, z), 3),
    (-x, 1),
]


@pytest.mark.parametrize(("expr", "count"), COUNTS)
def test_operations(expr: sp.Expr, count: int) -> None:
    assert count_operations(expr) == count
