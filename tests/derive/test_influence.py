"""What a result feels: internal forces that cancel, sides that do, and tampered ones that do
not.
"""

from __future__ import annotations

import pytest
import sympy as sp
from sympy import cos, pi, sin

from derive.functions import Polynomial
from derive.influence import Influence, NotAdditive, flatten_products, side_share
from derive.model import Call, Lane, Let, RuntimeFunction, Shared
from derive.quantity import OpenVector, Quantity, Vector


def quantity(name: str) -> Quantity:
    return Quantity(name, "1", f"{name} of the test", "test")


phi, arm, load, tension, size, above, below, turned, rate, slack, total, part = map(
    quantity,
    (
        "phi",
        "arm",
        "load",
        "tension",
        "size",
        "above",
        "below",
        "turned",
        "rate",
        "slack",
        "total",
        "part",
    ),
)
LAW = OpenVector("law", "numbers of a law", {}, sized_by=("turn", "law"))
TURN = RuntimeFunction("turn", "laws", ("angle", "law"), ("turned", "rate", "slack"))


def twin(symbol: Quantity) -> Quantity:
    return quantity(f"{symbol.name}_2")


COSINE = cos(phi)


def lane(reaction: int = 1, side: sp.Expr = COSINE, total_of: sp.Expr | None = None) -> Lane:
    """Two bodies that pull at each other, one carried round by the arm: the pull cancels, and so do
    the sides' arms.
    """
    steps = (
        Call((turned, rate, slack), TURN, phi, (LAW,), "test"),
        Let(tension, load * slack / size, "test"),
        Let(
            above, tension + rate * sin(turned) ** 2 + rate * cos(turned) ** 2 + arm * side, "test"
        ),
        Let(below, -reaction * tension + load, "test"),
    )
    sum_of_sides = above + below + twin(above) + twin(below) if total_of is None else total_of
    shared = Shared(twin, (Let(total, sum_of_sides, "test"),), Vector("totals", (total,)))
    return Lane(
        phi,
        (Vector("sizes", (arm, load, size)), LAW),
        steps,
        Vector("side", (above, below)),
        (),
        shared,
    )


def influence(lane_: Lane) -> Influence:
    return Influence(lane_, side_share(lane_, total, part))


def test_cancelling_steps_are_not_computed() -> None:
    result = influence(lane())
    assert {arm, size, tension, slack, turned} == result.without
    assert result.felt == {"turn": ("rate",)}
    assert [step.defines for step in result.reduced()] == [(rate,), (above,), (below,), (part,)]


def test_force_without_reaction_has_effect() -> None:
    result = influence(lane(reaction=2))
    assert not {size, tension, slack} & result.without
    assert "slack" in result.felt["turn"]


def test_uncancelled_lever_has_effect() -> None:
    assert arm not in influence(lane(side=cos(2 * phi))).without
    assert arm in influence(lane(side=cos(phi + pi / 3))).without
    assert arm not in influence(lane(side=cos(phi) * turned)).without


def test_a_result_is_written_out_without_squares_of_cosines() -> None:
    steps = flatten_products(influence(lane()).reduced(), part, frozenset({turned, rate}))
    (last,) = (step for step in steps if step.defines == (part,))
    assert isinstance(last, Let)
    assert last.expr == rate + load


def test_total_must_be_a_sum_of_sides() -> None:
    with pytest.raises(NotAdditive, match="total is not a sum of what each side does"):
        side_share(lane(total_of=above * twin(above)), total, part)
    bare = lane()
    with pytest.raises(NotAdditive, match="no equal sides"):
        side_share(Lane(phi, bare.inputs, bare.steps, bare.outputs), total, part)


def test_polynomial_derivative_uses_the_coefficients() -> None:
    x = sp.Symbol("x", real=True)
    law = x**4 * (3 - x) + 2 * x
    polynomial = Polynomial.of(law, x, sin(phi))
    assert sp.expand(polynomial.diff(phi).doit() - law.diff(x).subs(x, sin(phi)) * cos(phi)) == 0
    assert Polynomial.of(law, x, x).diff(x, 2).doit() == sp.expand(law.diff(x, 2))
