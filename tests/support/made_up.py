"""Made-up quantities, and points at which they have values, to judge small equations with."""

import random

import sympy as sp

from derive.audit.judge import Judgement, judge
from derive.equations import Equation, Relation
from derive.evaluate import Point
from derive.quantity import Quantity


def quantity(name: str, unit: str = "m") -> Quantity:
    return Quantity(name, unit, "made up", "test")


a, b, c, d, e = (quantity(f"test_{n}") for n in "abcde")
u, v, t = quantity("test_u", "1"), quantity("test_v", "1"), quantity("test_t", "s")
x, x_dot = quantity("testx"), quantity("testx_dot", "m/s")
WORDS = [a, b, c, d, e, u, v, t, x, x_dot]


def values(seed: int) -> dict[Quantity, sp.Rational]:
    rng = random.Random(seed)
    return {s: sp.Rational(rng.randint(10**9, 10**10), 10**10) for s in WORDS}


POINTS = [Point(values(seed)) for seed in (1, 2, 3)]


def judged(
    printed: sp.Expr,
    derived: sp.Expr,
    relations: tuple[Relation, Relation] = ("=", "="),
    defines: Quantity | None = None,
) -> Judgement:
    """The judgement on two residuals, or on what two formulas say that a symbol is."""
    first, second = (
        Equation("n", r if defines is None else defines - r, "test", "made up", defines=defines, relation=k)
        for r, k in zip((printed, derived), relations, strict=True)
    )
    return judge(first, second, POINTS, WORDS)
