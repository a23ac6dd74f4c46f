"""Laws of mechanics on a small arm in space and on a pair of gears, at a random state; errors break
them.
"""

from __future__ import annotations

import math
import random
from dataclasses import replace
from functools import cache

import mpmath
import pytest
import sympy as sp
from mpmath import mpf
from sympy import S

from derive.audit.user_mechanism.subject import evaluate_steps
from derive.evaluate import Point
from derive.mechanics.bodies import Action, action_load
from derive.mechanics.contacts import GearContact, SlidingContact, contour_steps, reach
from derive.mechanics.driven_motion import LAW, build_law_residuals, motion_steps, solve_forces
from derive.mechanics.frames import Frame, Y, Z, unit
from derive.mechanics.frames import Point as Place
from derive.mechanics.mechanism import Mechanism
from derive.quantity import Quantity

ANGLE, SPEED = Quantity("angle", "rad", "test", "test"), Quantity("speed", "rad/s", "test", "test")
DIGITS = 30


def quantity(name: str, unit: str) -> Quantity:
    return Quantity(name, unit, "test", "test")


m1, m2, m3 = (quantity(f"m{i}", "kg") for i in "123")
Ix, Iy, Iz, P = (quantity(f"I{a}", "kg m2") for a in ("x", "y", "z", "p"))
l, s, g, h = quantity("l", "m"), quantity("s", "m"), quantity("g", "m/s2"), quantity("h", "m/s2")  # noqa: E741
alpha, mu, T = quantity("alpha", "rad"), quantity("mu", "rad"), quantity("T", "N m")
k = quantity("k", "N/m")


@cache
def arm() -> Mechanism:
    """An upper arm turns about the vertical, a forearm of two parts about the upper arm's y, both
    driven.
    """
    m = Mechanism("arm", angle=ANGLE, speed=SPEED, gravity=(h, 0, -g), spatial=True)
    upper = m.frame("upper", ANGLE)
    lower = m.frame("lower", 2 * ANGLE + S.Half, Y, upper)
    elbow = m.point("elbow", m.O, upper, l, s, 0)
    first = m.body("upper", upper, m1, m.point("C1", m.O, upper, s, 0, l), (Ix, Iy, Iz, P, 0, 0))
    second = m.body("lower", lower, m2, m.point("C2", elbow, lower, s, l, 0), (Iz, Ix, Iy))
    three = m.body(
        "hand", lower, m3, m.point("C3", elbow, lower, 2 * l, 0, s), (Iy, Iz, Ix, 0, P, 0)
    )
    m.pin("O", first, m.ground, m.O)
    m.pin("E", second, first, elbow, Y)
    m.weld("H", three, second, m.point("H", elbow, lower, l))
    m.motor("M_O", first, m.ground, m.O)
    m.motor("M_E", second, first, elbow, Y)
    return m


@cache
def gears(rubbing: bool) -> Mechanism:
    """A round gear turns another of half its size against a torque; teeth that rub touch beyond the
    pitch point.
    """
    m = Mechanism("gears", angle=ANGLE, speed=SPEED, gravity=g)
    centre = m.point("B", m.O, m.world, 3 * l)
    inner, outer = m.frame("inner", ANGLE), m.frame("outer", -2 * ANGLE)
    first, second = (
        m.body("inner", inner, m1, m.O, Ix),
        m.body("outer", outer, m2, m.point("C", centre, outer, s), Iy),
    )
    m.pin("O", first, m.ground, m.O)
    m.pin("B", second, m.ground, centre)
    contact = SlidingContact(m.world, centre, l, alpha, mu, beyond=s / 9, turning=3 * SPEED)
    m.mesh("P", first, second, contact if rubbing else GearContact(m.world, centre, l, alpha))
    m.torque("load", second, m.ground, T)
    m.motor("M_in", first, m.ground, m.O)
    return m


@cache
def press() -> Mechanism:
    """A crank moves a slider in an inclined guide by a rod: a closed loop; the slider rubs, and a
    spring pulls it.
    """
    m = Mechanism("press", angle=ANGLE, speed=SPEED, gravity=(h, -g, 0))
    beta, way = m.coordinate("beta", "rad", "rod"), m.coordinate("way", "m", "slider")
    crank, rod, guide = m.frame("crank", ANGLE), m.frame("rod", beta), m.frame("guide", S.Half)
    A, slot = m.point("A", m.O, crank, l), m.point("slot", m.O, guide, way, s)
    B = m.point("B", A, rod, 5 * l)
    m.close(B, slot, start={beta: S.Zero, way: 5 * l})
    first, second = (
        m.body("crank", crank, m1, m.point("C1", m.O, crank, s, s), Ix),
        m.body("rod", rod, m2, A, Iy),
    )
    three, base = m.body("slider", guide, m3, slot, Iz), m.body("base", guide)
    m.weld("base", base, m.ground, m.O)
    m.pin("O", first, m.ground, m.O)
    m.pin("A", second, first, A)
    m.pin("B", three, second, slot)
    m.slide("G", three, base, slot, friction=mu, origin=m.O)
    m.spring("spring", three, m.ground, (slot, m.point("anchor", m.O, m.world, 9 * l, l)), k, s)
    m.motor("M_in", first, m.ground, m.O)
    return m


@cache
def cam() -> Mechanism:
    """A cam lifts a follower in a guide, with friction where they touch."""
    m = Mechanism("cam", angle=ANGLE, speed=SPEED, gravity=g)
    turned = m.frame("cam", ANGLE)
    roller = m.point("roller", m.O, m.world, s / 9, 2 * l + s * sp.sin(ANGLE) / 5)
    first, second = m.body("cam", turned, m1, m.O, Ix), m.body("follower", m.world, m2, roller)
    m.pin("O", first, m.ground, m.O)
    m.slide("G", second, m.ground, roller, Y)
    m.follower("F_E", second, first, roller, m.O, mu, across=-unit(m.world, Z))
    m.motor("M_in", first, m.ground, m.O)
    return m


MECHANISMS = {
    "press": press,
    "cam": cam,
    "arm": arm,
    "gears": lambda: gears(False),
    "gears that rub": lambda: gears(True),
}
SPACE = {f"{kind}_{axis}" for kind in ("force", "moment") for axis in "xyz"} | {"power"}
PLANE = {"force_x", "force_y", "moment_z", "power"}
ROLLING = {"roll_Px", "roll_Py"}


def state(m: Mechanism, spoilt: Action | None = None) -> dict[str, mpf]:
    """Every step at a random state: motion, forces from the balances, what laws leave, a ``spoilt``
    action reversed.
    """
    rng, symbols = (
        random.Random(4),
        (m1, m2, m3, Ix, Iy, Iz, P, l, s, g, h, alpha, mu, T, k, ANGLE, SPEED),
    )
    actions = m.assembly.actions
    with mpmath.workdps(DIGITS):
        steps = [*motion_steps(m), *solve_forces(m)]
        values = {q: mpf(rng.uniform(0.2, 0.9)) for q in symbols}
        values |= _closed(values) if m.loops.coordinates else {}
        m.assembly.actions = [
            replace(a, force=-a.force, moment=-a.moment) if a is spoilt else a for a in actions
        ]
        try:
            steps += [*build_law_residuals(m, []), *m.reports]
        finally:
            m.assembly.actions = actions
        return {str(q): v for q, v in evaluate_steps(steps, values).items()}


def _closed(values: dict[Quantity, mpf]) -> dict[Quantity, mpf]:
    """The rod's angle and the slider's place by trigonometry, in the guide's own axes, somewhat
    off.
    """
    beta, way = press().loops.given
    aside = values[l] * mpmath.sin(values[ANGLE] - mpf("0.5"))
    slope = mpmath.asin((values[s] - aside) / (5 * values[l]))
    projection = values[l] * mpmath.cos(values[ANGLE] - mpf("0.5")) + 5 * values[l] * mpmath.cos(
        slope
    )
    return {beta: slope + mpf("0.5") + mpf(10) ** -9, way: projection}


def test_loops_are_closed_where_they_were_nearly() -> None:
    """To the square of the square of the error, and the slider is where trigonometry says."""
    values = state(press())
    assert abs(values["way"] - values["way_given"]) < mpf(10) ** (5 - DIGITS)
    assert abs(values["beta"] - values["beta_given"] + mpf(10) ** -9) < mpf(10) ** (5 - DIGITS)


def broken(m: Mechanism, spoilt: Action | None = None) -> set[str]:
    """Laws that do not vanish to rounding."""
    left = {n.removeprefix(LAW): abs(v) for n, v in state(m, spoilt).items() if n.startswith(LAW)}
    assert set(left) == (SPACE if m.spatial else PLANE) | (ROLLING if m.rolling else set())
    return {name for name, value in left.items() if value > mpf(10) ** (5 - DIGITS)}


@pytest.mark.parametrize("name", MECHANISMS)
def test_solved_forces_satisfy_the_laws(name: str) -> None:
    assert not broken(MECHANISMS[name]())


@pytest.mark.parametrize("name", MECHANISMS)
def test_reversed_ground_force_violates_momentum(name: str) -> None:
    m = MECHANISMS[name]()
    outer = [a for a in m.assembly.actions if m.ground in (a.on, a.by) and any(a.force.components)]
    assert outer
    assert all({"force_x", "force_y"} & broken(m, spoilt) for spoilt in outer)


def test_contacts_dissipate_only_by_friction() -> None:
    for m, name, rubbing in (
        (gears(False), "F_P", False),
        (gears(True), "F_P", True),
        (cam(), "F_E", True),
    ):
        action = next(a for a in m.assembly.actions if a.name == name)
        worked = sum(
            (f.dot(v) for f, v in action_load(m.motion, action, m.ground, m.anchor)), S.Zero
        )
        with mpmath.workdps(DIGITS):
            values = state(m)
            point = Point({q: values[str(q)] for q in worked.free_symbols})
            lost = values.get(f"{name}_loss", mpf(0))
            assert abs(point(worked) + lost) < mpf(10) ** (5 - DIGITS)
        assert (lost > 0) == rubbing


@pytest.mark.parametrize("bearing", [1, -1])
@pytest.mark.parametrize("beyond", [0.2, -0.3])
@pytest.mark.parametrize("turning", [5.0, -7.0])
@pytest.mark.parametrize("share", [1, 0])
def test_friction_of_teeth_is_against_their_sliding_or_outwards(
    bearing: int, beyond: float, turning: float, share: int
) -> None:
    """The gears turn about the pitch point against each other, so the contact slides across the
    line of action.
    """
    friction, pressure = 0.1, 0.4
    numbers = {"beyond": sp.Float(beyond), "turning": sp.Float(turning), "share": sp.Integer(share)}
    contact = SlidingContact(
        Frame("line"), Place("B"), S(2), sp.Float(pressure), sp.Float(friction), **numbers
    )
    fx, fy, _ = map(float, contact.flank(bearing))
    angle = math.pi / 2 + pressure if bearing > 0 else 1.5 * math.pi - pressure
    nx, ny = math.cos(angle), math.sin(angle)
    assert fx * nx + fy * ny == pytest.approx(1)
    slides = turning * beyond
    lost = -(fx * -ny + fy * nx) * slides
    outwards = fx * math.cos(pressure) + fy * bearing * math.sin(pressure)
    if share:
        assert (
            lost == pytest.approx(math.tan(friction) * abs(slides)) == float(contact.loss(bearing))
        )
    else:
        assert outwards == pytest.approx(math.tan(friction))
        assert float(contact.loss(bearing)) == 0


def test_contour_is_offset_by_the_roller_radius() -> None:
    """Against differences of the numbers themselves, of a roller's centre on an ellipse that is
    passed unevenly.
    """
    t, radius, step = sp.Symbol("t", real=True), mpf("0.3"), mpf(10) ** -12
    place = (2 * sp.cos(t + t**2 / 9), sp.sin(t + t**2 / 9))
    first, second = ([sp.diff(c, t, order) for c in place] for order in (1, 2))
    steps = contour_steps(place, tuple(first), tuple(second), (S.One, S(2)))
    shift = mpf("0.7")

    def at(when: mpf) -> dict[str, mpf]:
        values = {t: when, reach: radius}
        for let in steps:
            values[let.symbol] = Point(values)(let.expr)
        return {str(q): v for q, v in values.items()} | {
            a: Point(values)(c) for a, c in zip("xy", place, strict=True)
        }

    with mpmath.workdps(DIGITS):
        before, now, later = (at(shift + d) for d in (-step, mpf(0), step))

        def rate(name: str) -> mpf:
            return (later[name] - before[name]) / (2 * step)

        contact = [now[f"contact_{a}"] - now[a] for a in "xy"]
        way = [rate(a) for a in "xy"]
        speed = mpmath.norm(way)
        assert abs(mpmath.norm(contact) - radius) < mpf(10) ** -12
        assert abs(contact[0] * way[0] + contact[1] * way[1]) < mpf(10) ** -12
        assert contact[0] * way[1] - contact[1] * way[0] < 0
        assert abs(mpmath.atan2(way[1], way[0]) - now["heading"]) < mpf(10) ** -12
        assert abs(rate("heading") / speed - now["kappa"]) < mpf(10) ** -10
        tangential = rate("contact_x") * way[0] + rate("contact_y") * way[1]
        assert abs(tangential / speed**2 - now["room"]) < mpf(10) ** -10
        leaves = (contact[0] + 2 * contact[1]) / (radius * mpmath.sqrt(5))
        assert abs(mpmath.cos(now["pressure"]) - abs(leaves)) < mpf(10) ** -12
