"""Compliant contacts, friction, accelerations in symbols, slopes along named steps: on made-up
mechanisms.
"""

import pytest
import sympy as sp
from sympy import cos, sin

from derive import Followed, Impact, ImpactLaw, Mechanism, Quantity, creeping, dahl, quantities
from derive.mechanics.bodies import kinetic_energy
from derive.mechanics.statement import MechanismError


def q(name: str, unit: str = "m") -> Quantity:
    return Quantity(name, unit, name, "test")


x, y, x_dot, y_dot = q("x"), q("y"), q("x_dot", "m/s"), q("y_dot", "m/s")
LAW = ImpactLaw(
    q("K", "N/m1.5"), sp.Rational(3, 2), q("D", "s/m"), q("mu", "1"), q("creep", "m/s"), q("least")
)
IMPACT = Impact(
    gap=q("gap"),
    depth=q("depth"),
    elastic=q("elastic", "N"),
    closing=q("closing", "m/s"),
    normal=q("normal", "N"),
    slip=(q("slip", "m/s"),),
    drag=q("drag", "N s/m"),
    rates=(x_dot, y_dot),
    forces=(q("on_x", "N"), q("on_y", "N")),
    stored=q("stored", "J"),
    damped=q("damped", "W"),
    rubbed=q("rubbed", "W"),
)


def on_a_slope(numbers: dict[sp.Symbol, float], slip: sp.Expr) -> dict[str, float]:
    """A point above a plane y = x/2, by numbers."""
    length = sp.sqrt(5) / 2
    gap, opening = (y - x / 2) / length, (y_dot - x_dot / 2) / length
    values: dict[sp.Symbol, sp.Expr] = dict(numbers)
    for step in IMPACT.steps(gap, opening, (slip,), LAW):
        values[step.symbol] = step.expr.subs(values)
    return {str(symbol): float(value) for symbol, value in values.items()}


NUMBERS = {
    x: 0.1,
    y: 0.04,
    x_dot: 0.3,
    y_dot: -0.2,
    q("K", "N/m1.5"): 1e4,
    q("D", "s/m"): 2.0,
    q("mu", "1"): 0.3,
    q("creep", "m/s"): 1e-3,
    q("least"): 1e-30,
}
ALONG = (x_dot + y_dot / 2) / (sp.sqrt(5) / 2)


def test_contact_force_on_an_inclined_plane() -> None:
    forces = on_a_slope(NUMBERS, ALONG)
    depth = (0.05 - 0.04) / (5**0.5 / 2)
    closing = (0.2 + 0.15) / (5**0.5 / 2)
    normal = 1e4 * depth**1.5 * (1 + 2 * closing)
    assert forces["normal"] == pytest.approx(normal)
    assert (-forces["on_x"] * 0.5 + forces["on_y"]) / (5**0.5 / 2) == pytest.approx(normal)
    tangential = (forces["on_x"] + forces["on_y"] * 0.5) / (5**0.5 / 2)
    slip = 0.2 / (5**0.5 / 2)
    assert tangential == pytest.approx(-0.3 * normal * slip / (slip**2 + 1e-6) ** 0.5)
    assert forces["stored"] == pytest.approx(0.4 * 1e4 * depth**2.5)
    lost = forces["damped"] + forces["rubbed"]
    power = forces["on_x"] * 0.3 + forces["on_y"] * -0.2
    assert -power == pytest.approx(1e4 * depth**1.5 * closing + lost)


def test_open_contact_has_no_force() -> None:
    forces = on_a_slope(NUMBERS | {y: 0.06}, ALONG)
    assert [forces[name] for name in ("normal", "on_x", "on_y", "stored", "damped", "rubbed")] == [
        0
    ] * 6


def test_nonlinear_rates_are_refused() -> None:
    with pytest.raises(ValueError, match="is not linear in x_dot"):
        IMPACT.steps(y, y_dot, (x_dot**3,), LAW)


def test_creeping_friction_tends_to_coulomb() -> None:
    force = creeping(sp.Integer(10), (x_dot, y_dot), sp.Rational(1, 10**6)) * x_dot
    assert float(force.subs({x_dot: 3, y_dot: 4})) == pytest.approx(6)
    assert force.subs({x_dot: 0, y_dot: 0}) == 0


def test_bristles_bend_up_to_their_limit() -> None:
    (rate,), lost = dahl((x_dot,), (x,), sp.Integer(50), sp.Integer(10), sp.Integer(0))
    assert rate.subs({x_dot: 2, x: 0}) == 2
    assert rate.subs({x_dot: 2, x: sp.Rational(10, 50)}) == 0
    assert lost.subs({x_dot: 2, x: sp.Rational(10, 50)}) == 10 * 2
    assert rate.subs({x_dot: 2, x: sp.Rational(9, 50)}) > 0


def test_free_cart_pendulum_conserves_energy() -> None:
    table = quantities(
        "m | kg | bob | 1\n arm | m | arm | 1\n g | m/s2 | free fall | 9.81\n push | N | push | 1"
    )
    m = Mechanism("cart", table, gravity=table.g)
    place, angle = (
        m.coordinate("place", "m", "cart"),
        m.coordinate("angle", "rad", "arm, from below"),
    )
    cart, rod = m.point("cart", m.O, m.world, place), m.frame("rod", angle)
    trolley = m.body("cart", m.world, table.m, cart)
    bob = m.body("bob", rod, table.m, m.point("bob", cart, rod, 0, -table.arm))
    m.pin("cart", bob, trolley, cart)
    m.force("push", trolley, cart, m.vector(m.world, table.push))
    accelerations = m.accelerations()
    rates = [m.motion.rates[s] for s in (place, angle)]
    moving = dict(zip((place, angle, *rates), (*rates, *accelerations), strict=True))
    energy = kinetic_energy(m.motion, m.bodies, m.world) - table.m * table.g * table.arm * cos(
        angle
    )
    gained = sum((energy.diff(s) * rate for s, rate in moving.items()), sp.S.Zero)
    assert sp.simplify(gained - table.push * rates[0]) == 0
    assert sp.simplify(accelerations[0].subs({angle: 0, rates[1]: 0}) - table.push / table.m) == 0


def test_symbolic_accelerations_need_free_motion() -> None:
    m = Mechanism("held", quantities("r | m | radius | 1"))
    m.constrain("rope", m.coordinate("x", "m", "place") - 1, {})
    with pytest.raises(
        MechanismError, match="held: accelerations in symbols are those without gap_rope"
    ):
        m.accelerations()


def test_slopes_along_named_steps_are_those_of_the_whole() -> None:
    k = Followed((x, y))
    inner = k.let(q("inner", "m2"), x * y + x**2)
    outer = k.let(q("outer", "m2"), sp.Piecewise((sin(inner), x > y), (inner**2, True)))
    composed = sp.Piecewise((sin(x * y + x**2), x > y), ((x * y + x**2) ** 2, True))
    for at in ({x: 0.7, y: 0.2}, {x: 0.2, y: 0.7}):
        named = {**at, inner: (x * y + x**2).subs(at)}
        for coordinate in (x, y):
            assert k.along(outer, coordinate).subs(named) == pytest.approx(
                composed.diff(coordinate).subs(at)
            )
    assert k.slopes(q("constant")) == {}
