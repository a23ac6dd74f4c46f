"""The mechanics layer against textbook results, and the planting device rebuilt with parts moved,
turned and added.
"""

from pathlib import Path

import pytest
import sympy as sp
from sympy import S, cos, sin

from derive.chain import ordered
from derive.mechanics.frames import (
    Frame,
    FrameError,
    Motion,
    Point,
    Vec,
    X,
    Y,
    Z,
    displacement,
    rotation,
    shorten_vector,
    unit,
)
from derive.mechanics.mechanism import Mechanism
from derive.papers.planting import derivation
from derive.papers.planting import quantities as q
from derive.quantity import Quantity


def quantity(name: str, unit: str = "1") -> Quantity:
    return Quantity(name, unit, "test", "test")


angle, rate, acceleration = (
    quantity("angle", "rad"),
    quantity("rate", "rad/s"),
    quantity("acceleration", "rad/s2"),
)
turn = quantity("turn", "rad")
spin = quantity("spin", "rad/s")
mass, length, g = quantity("mass", "kg"), quantity("length", "m"), quantity("g", "m/s2")
Ix, Iy, Iz = (quantity(f"I{a}", "kg m2") for a in "xyz")
WORLD = Frame("world")
O = Point("O")  # noqa: E741


def moving() -> Motion:
    return Motion(rates={angle: rate, rate: acceleration, turn: spin})


def mechanism(gravity: Quantity | int = 0) -> Mechanism:
    """Bodies in space in that motion."""
    m = Mechanism("test", angle=turn, speed=spin, gravity=gravity, spatial=True)
    m.motion.rates |= moving().rates
    return m


def test_vectors_of_different_frames_do_not_mix() -> None:
    turned = Frame("turned", WORLD, Z, angle)
    with pytest.raises(FrameError, match="frame world meets one in frame turned"):
        unit(WORLD, X) + unit(turned, X)
    assert (unit(WORLD, X) + unit(turned, X).resolved(WORLD))[0] == 1 + cos(angle)


@pytest.mark.parametrize("axis", [X, Y, Z])
def test_rotation_is_orthogonal_with_fixed_axis(axis: tuple[int, int, int]) -> None:
    matrix = rotation(axis, angle)
    assert sp.simplify(matrix * matrix.T) == sp.eye(3)
    assert matrix * sp.Matrix(axis) == sp.Matrix(axis)


def test_rotation_about_y_carries_x_to_minus_z() -> None:
    assert rotation(Y, sp.pi / 2) * sp.Matrix([1, 0, 0]) == sp.Matrix([0, 0, -1])


def test_resolving_back_restores_the_vector() -> None:
    first = Frame("first", WORLD, Z, angle)
    second = Frame("second", first, Y, turn)
    vector = Vec(second, (Ix, Iy, Iz))
    back = vector.resolved(WORLD).resolved(second)
    assert [
        sp.simplify(a - b) for a, b in zip(back.components, vector.components, strict=True)
    ] == [0, 0, 0]


@pytest.mark.parametrize("turned", [S.Zero, S.One, S.NegativeOne, angle])
def test_rotations_about_a_common_axis_add_up(turned: sp.Expr) -> None:
    first = Frame("first", WORLD, Z, turned)
    assert unit(first, X).resolved(WORLD).components == (cos(turned), sin(turned), 0)
    frame = Frame("second", first, Z, angle)
    assert unit(frame, X).resolved(WORLD).components == (
        cos(angle + turned),
        sin(angle + turned),
        0,
    )


def test_component_is_expanded_only_if_shorter() -> None:
    cancels, powers = (length + 1) ** 2 - length**2 - 1, (length + mass) ** 4
    long = sp.Add(*(sin(i * length) ** 2 * (length + i) for i in range(1, 20))) + cancels
    vector = shorten_vector(Vec(WORLD, (cancels, powers, long)))
    assert vector.components == (2 * length, powers, long)


def test_transport_acceleration_equals_second_derivative() -> None:
    """A point in a frame that swings on a turning frame: both ways of differentiating must
    agree.
    """
    motion = moving()
    inner = Frame("inner", Frame("outer", WORLD, Z, turn), Y, angle)
    point = Point("P", O, Vec(inner, (length, S.Zero, S.Zero)))
    by_transport = motion.acceleration(point, inner).resolved(WORLD)
    place = displacement(O, point, WORLD)
    direct = [motion.rate(motion.rate(c)) for c in place.components]
    assert [sp.simplify(a - b) for a, b in zip(by_transport.components, direct, strict=True)] == [
        0,
        0,
        0,
    ]


def test_pendulum() -> None:
    """(I + m l^2) a = -m g l sin(angle) (any mechanics text)."""
    frame = Frame("rod", WORLD, Z, angle)
    centroid = Point("C", O, Vec(frame, (S.Zero, -length, S.Zero)))
    m = mechanism(gravity=g)
    rod = m.body("rod", frame, mass, centroid, (Ix, Iy, Iz), about=O)
    m.pin("O", rod, m.ground, O)
    residual = next(
        e.residual for e in m.equations() if e.number == "rod: moment along z of world about O"
    )
    assert (
        sp.simplify(
            residual + mass * g * length * sin(angle) + (Iz + mass * length**2) * acceleration
        )
        == 0
    )


def gyroscopic_residuals(inertia: tuple) -> list:
    """Moments about its own axes of a body that swings about its y while the whole turns about
    z.
    """
    frame = Frame("rotor", Frame("table", WORLD, Z, turn), Y, angle)
    m = mechanism()
    rotor = m.body("rotor", frame, mass, O, inertia, about=O, axes=frame)
    return [e.residual for e in m.assembly.balances(rotor, m.pin_of(rotor))][3:]


def test_gyroscopic_terms_are_eulers() -> None:
    """I dw/dt + w x I w with w = (-spin sin, rate, spin cos) (Goldstein, Classical Mechanics,
    5.39).
    """
    w = sp.Matrix([-spin * sin(angle), rate, spin * cos(angle)])
    dw = sp.Matrix([-spin * rate * cos(angle), acceleration, -spin * rate * sin(angle)])
    inertia = sp.diag(Ix, Iy, Iz)
    euler = inertia * dw + w.cross(inertia * w)
    assert [
        sp.simplify(a + b) for a, b in zip(gyroscopic_residuals((Ix, Iy, Iz)), euler, strict=True)
    ] == [0, 0, 0]


def test_ball_has_no_gyroscopic_moment() -> None:
    assert sp.simplify(gyroscopic_residuals((Ix, Ix, Ix))[1] + Ix * acceleration) == 0
    assert sp.simplify(gyroscopic_residuals((Ix, Iy, Iz))[1] + Iy * acceleration) != 0


def test_every_action_appears_on_two_bodies_with_opposite_sign() -> None:
    device = derivation.build_device().assembly
    assert len(device.actions) == 14
    for action in device.actions:
        signs = sorted(action.sign(body) for body in device.bodies)
        assert signs == [-1, *[0] * (len(device.bodies) - 2), 1], action.name


def test_ideal_coupling_does_no_work() -> None:
    """Moments on two hinges that swing oppositely: their powers cancel."""
    actions = derivation.build_device().assembly.actions
    on_inner, on_outer = (
        next(a.moment[1] for a in actions if a.name == "M_K" and a.on.name == body)
        for body in ("inner half", "outer half")
    )
    assert on_inner * q.theta1_dot + on_outer * (-q.theta1_dot) == 0
    assert on_inner != 0


def solved(device: Mechanism, extra: tuple[Quantity, ...] = ()) -> dict[str, sp.Expr]:
    lets = ordered(device.equations(), device.unknowns, (*q.REPORTED_EXACT, *extra)).lets()
    return {let.symbol.name: let.expr for let in lets}


POINT = {
    s: sp.Rational(2 * i + 3, 7 * i + 11) for i, s in enumerate(sorted(q.TABLE.values(), key=str))
}


def values(device: Mechanism) -> dict[str, float]:
    """Numbers for every solved unknown at one arbitrary point, kinematics included."""
    substitutions = dict(POINT)
    for step in device.named:
        substitutions[step.symbol] = step.expr.xreplace(substitutions).evalf(30)
    for name, expr in solved(device).items():
        symbol = next(u for u in device.unknowns if u.name == name)
        substitutions[symbol] = expr.xreplace(substitutions).evalf(30)
    return {str(s): float(v) for s, v in substitutions.items()}


def changed(device: Mechanism) -> set[str]:
    before, after = values(derivation.build_device()), values(device)
    shared = before.keys() & after.keys()
    return {
        name
        for name in shared
        if abs(before[name] - after[name]) > 1e-12 * max(1, abs(before[name]))
    }


def test_moved_hinge_changes_every_dependent_force() -> None:
    shift = Vec(derivation.PLANET, (S.Zero, q.L_tip, S.Zero))
    moved = Point("A", derivation.A, shift)
    differing = changed(derivation.build_device(hinge=moved))
    assert {
        "F_Ax",
        "F_Ay",
        "F_Aox",
        "F_Aoy",
        "F_E",
        "M_Q",
        "F_NQ",
        "F_B1x",
        "F_B1y",
        "M_P",
        "F_A1x",
        "F_A1y",
    } <= differing
    assert not differing & {"phi72_ddot", "ax_A1", "ax_B1", "theta1", "S", "xi1"}


def test_rotated_hinge_axis_changes_dependent_forces() -> None:
    differing = changed(derivation.build_device(hinge_axis=X))
    assert {"F_Ax", "F_Ay", "F_E", "M_Q", "F_B1x", "M_P", "F_A1x"} <= differing
    assert not differing & {"phi72_ddot", "ax_A", "ay_A", "r5"}


def test_a_third_cam_driven_part_takes_under_ten_lines() -> None:
    device, planet = derivation.build_device(), derivation.PLANET
    bodies = {body.name: body for body in device.bodies}
    lift = quantity("lift", "rad")
    flap_frame = device.frame("flap", lift, Y, planet)
    hinge = device.point("G", derivation.B1, planet, length)
    centroid = device.point("CG", hinge, flap_frame, length, length, length)
    flap = device.body("flap", flap_frame, mass, centroid, (Ix, Iy, Iz), about=hinge, axes=planet)
    device.pin("G", flap, bodies["planet"], hinge, Y, axes=planet)
    force = device.follower(
        "F_H", flap, bodies["carrier"], centroid, derivation.B1, q.mu1, unit(planet, Y)
    )

    without, with_flap = solved(derivation.build_device()), solved(device, (force,))
    assert {mass, length} <= with_flap["F_H"].free_symbols
    planet_force = {str(s) for s in with_flap["F_B1x"].free_symbols} - {
        str(s) for s in without["F_B1x"].free_symbols
    }
    assert planet_force == {"F_Gx", "F_Gy"}
    assert with_flap["F_E"] == without["F_E"]


def test_follower_without_sliding_is_refused() -> None:
    device = derivation.build_device()
    bodies = {body.name: body for body in device.bodies}
    across = unit(derivation.PLANET, Y)
    with pytest.raises(ValueError, match="does not slide"):
        device.follower(
            "F_H", bodies["planet"], bodies["carrier"], derivation.TIP, derivation.B1, q.mu1, across
        )


def test_the_mirror_plane_cancels() -> None:
    """The paper does not say where the outer half sits; no step of the exact model depends on
    it.
    """
    system = derivation.build_exact_system()
    assert all(q.z_mirror not in step.needs for step in system.steps)


def test_no_force_balance_is_typed_into_the_system() -> None:
    """Every reaction is a quantity that the mechanics layer made, none is written in the system's
    text.
    """
    text = Path(derivation.__file__).read_text(encoding="utf-8")
    body = text.split("def build_device", 1)[1].split("m.reports", 1)[0]
    assert not [name for name in ("q.F_", "q.M_", "ddot", "ax_", "ay_") if name in body]
