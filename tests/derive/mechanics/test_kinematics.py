"""Motions by names against textbook results: named coordinates, places, accelerations, gear
stages.
"""

from pathlib import Path

import pytest
import sympy as sp
from sympy import S, cos, sin

from derive import mechanics
from derive.mechanics.frames import Frame, Point, Vec, Z
from derive.mechanics.kinematics import FollowerLaw, GearStage
from derive.mechanics.mechanism import Mechanism
from derive.model import Call
from derive.papers.planting import derivation
from derive.papers.planting import quantities as q
from derive.quantity import OpenVector, Quantity


def quantity(name: str, unit: str = "1") -> Quantity:
    return Quantity(name, unit, f"{name} of the test", "test")


phi, omega, length = quantity("phi", "rad"), quantity("omega", "rad/s"), quantity("length", "m")
swing = (quantity("swing", "rad"), quantity("swing_dot", "rad/s"), quantity("swing_ddot", "rad/s2"))
x, y, ax, ay = (
    quantity(name, unit) for name, unit in (("x", "m"), ("y", "m"), ("ax", "m/s2"), ("ay", "m/s2"))
)
WORLD = Frame("world")
CRANK = Frame("crank", WORLD, Z, phi)
O = Point("O")  # noqa: E741
PIN = Point("pin", O, Vec(CRANK, (length, S.Zero, S.Zero)))
STAGE = GearStage(7, OpenVector("parameters7", "test", {}), OpenVector("hoisted7", "test", {}))
CONTACT = {name: quantity(f"{name}7") for name in ("r", "dr", "ratio", "dratio", "turned", "start")}


def mechanism() -> Mechanism:
    return Mechanism("test", angle=phi, speed=omega)


def lets(m: Mechanism) -> dict[Quantity, sp.Expr]:
    return {step.symbol: step.expr for step in m.named}


def test_coordinate_has_rate_and_acceleration() -> None:
    k = mechanism()
    k.follow(swing, sin(phi))
    assert lets(k) == {
        swing[0]: sin(phi),
        swing[1]: omega * cos(phi),
        swing[2]: -(omega**2) * sin(phi),
    }
    assert k.motion.rate(swing[0] ** 2) == 2 * swing[0] * swing[1]


def test_a_pin_on_a_crank_falls_towards_the_axis() -> None:
    """r omega^2 inwards (any mechanics text); a wrong sign would leave a remainder."""
    k = mechanism()
    k.name_acceleration(PIN, WORLD, (ax, ay))
    assert [sp.simplify(e) for e in lets(k).values()] == [
        -length * omega**2 * f(phi) for f in (cos, sin)
    ]
    assert k.motion.accelerations[PIN].components == (ax, ay, 0)


def test_a_pin_on_a_crank_moves_across_it() -> None:
    velocity = mechanism().velocity(PIN)
    assert [sp.simplify(c) for c in velocity.components] == [
        -length * omega * sin(phi),
        length * omega * cos(phi),
        0,
    ]


def test_unnamed_component_is_unchanged() -> None:
    k = mechanism()
    k.name_acceleration(PIN, WORLD, (ax,))
    assert sp.simplify(k.motion.accelerations[PIN][1] + length * omega**2 * sin(phi)) == 0


def test_named_point_moves_with_the_original() -> None:
    k = mechanism()
    k.name_place(PIN, O, WORLD, (x, y))
    at = lets(k)
    for symbol in (x, y):
        assert sp.simplify(k.motion.rate(symbol).xreplace(at) - k.motion.rate(at[symbol])) == 0


def test_a_stage_is_called_at_the_start_and_along_the_angle() -> None:
    k = mechanism()
    t = quantity("t7", "rad")
    k.stage(STAGE, t, 2 * phi + 1, **CONTACT)
    start, moving = (step for step in k.steps if isinstance(step, Call))
    assert (start.argument, start.defines) == (1, (CONTACT["start"],))
    assert start.source == "derived: stage 7, phi = 0"
    assert set(moving.defines) == set(CONTACT.values()) - {CONTACT["start"]}
    assert k.motion.rate(CONTACT["turned"]) == 2 * omega * CONTACT["ratio"]


def test_a_stage_whose_start_nobody_knows_is_refused() -> None:
    """The same is taken where the coordinate says what it is at the start."""
    t = quantity("t7", "rad")
    k = mechanism()
    k.follow(swing, phi**2)
    with pytest.raises(ValueError, match="stage 7: nothing says what swing is at phi = 0"):
        k.stage(STAGE, t, swing[0], **CONTACT)
    kinematics = mechanism()
    kinematics.follow(swing, phi**2, at_start=S.Zero)
    kinematics.stage(STAGE, t, swing[0], **CONTACT)


def test_cam_flank_has_cam_speed_and_breakpoint_events() -> None:
    k = mechanism()
    position, at, pace = quantity("within", "rad"), quantity("x"), quantity("pace", "1/rad")
    shares = tuple(quantity(name) for name in ("share", "slope", "bend"))
    k.motion.rates[position] = 3 * omega
    k.flank(
        FollowerLaw("law", (S.Zero, S.Half, S.One)),
        "rise",
        (position, 3 * phi),
        (S.One, S(3)),
        at,
        pace,
        shares,
    )
    expressions = {step.symbol: step.expr for step in k.named}
    assert [expressions[at].xreplace({position: S(value)}) for value in (0, 2, 4)] == [0, S.Half, 1]
    assert [expressions[pace].xreplace({position: S(value)}) for value in (0, 2, 4)] == [
        0,
        S.Half,
        0,
    ]
    assert (k.motion.rate(shares[0]), k.motion.rate(shares[1])) == tuple(
        3 * omega * pace * s for s in shares[1:]
    )
    assert [(e.name, e.argument, e.target, e.order, e.period, e.position) for e in k.events] == [
        ("cam, start of the rise", 3 * phi, 1, 2, 2 * sp.pi, 0),
        ("cam, 1/2 of the rise", 3 * phi, 2, 2, 2 * sp.pi, S.Half),
        ("cam, end of the rise", 3 * phi, 3, 2, 2 * sp.pi, 1),
    ]


def test_mirror_image_uses_names_of_the_original() -> None:
    k = mechanism()
    z = quantity("z", "m")
    left, right = (
        Point(name, O, Vec(CRANK, (length, S.Zero, at * length)))
        for name, at in (("l", 1), ("r", 4))
    )
    k.name_place(left, O, CRANK, (x, y, z))
    plane = sp.Rational(5, 2) * length
    k.mirror_place(right, left, O, CRANK, plane)
    assert k.motion.arm(O, right, CRANK).components == (x, y, 2 * plane - z)
    with pytest.raises(ValueError, match="r is not the mirror image of l"):
        k.mirror_place(right, left, O, CRANK, length)


def test_missing_law_of_an_unknown_is_refused() -> None:
    mechanism = derivation.build_device().assembly
    assert mechanism.law(q.F_E_loss).symbol == q.F_E_loss
    with pytest.raises(ValueError, match="no contact says what F_Ax is"):
        mechanism.law(q.F_Ax)


def test_the_mechanics_knows_no_machine() -> None:
    for path in Path(mechanics.__path__[0]).glob("*.py"):
        text = path.read_text(encoding="utf-8")
        assert "systems" not in text, path.name
        assert "planting" not in text.lower(), path.name
