"""Laws of gear pairs for every family of pitch curves, at random sizes, and of the devices with any
two of them.

Each law is a function that returns by how much it is broken; beside it stands a case in which it
is.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, TypeVar

import mpmath
import numpy as np
import pytest
from mpmath import mp
from numpy.typing import NDArray
from scipy.optimize import brentq

from planter.errors import GeometryError
from planter.gears.geometry import families
from planter.gears.geometry.stage import SERIES_TOLERANCE, StageCandidate
from planter.kernels import Kernel
from planter.numerics import extrema
from planter.papers.planting.model import Device
from tests.laws.test_gradients import TOLERANCE, errors, smooth_point
from tests.laws.test_planting_laws import momentum_rate, weight
from tests.support import kinematics, model, pairs, xp_complex, xp_mpmath
from tests.support.joints import gauss_points, of_side, of_teeth
from tests.support.sizing import Size

Array = NDArray[np.float64]
Chosen = TypeVar("Chosen", bound=tuple[object, ...])


def sampled(cases: Sequence[Chosen], sample: Sequence[Chosen]) -> list[Any]:
    """All cases, those of the suite bare and the others for the long tests."""
    return [
        case if case in sample else pytest.param(*case, marks=pytest.mark.long) for case in cases
    ]


TURN = 2 * np.pi
SOME_CURVES = [case for case in pairs.EVERY_CURVE if case[1] < 3]
every_curve = pytest.mark.parametrize(("family", "seed"), sampled(pairs.EVERY_CURVE, SOME_CURVES))
every_family = pytest.mark.parametrize(
    "family", sorted({family for family, _ in pairs.EVERY_CURVE})
)
OFF = 1 + 1e-6


def contact(
    family: str, seed: int, t: Array, stretched: float = 1.0, terms: int | None = None
) -> dict[str, Array]:
    """Contact at polar angles from the array code, real or complex, at a centre distance stretched
    by a factor.
    """
    code, parameters = model.array_module(f"curve_{family}"), pairs.parameters(family, seed)
    hoisted = code.prologue(
        np, parameters, pairs.stage(family, seed).terms if terms is None else terms
    )
    hoisted[0] = hoisted[0] * stretched
    names = ("r", "dr", "ddr", "ratio", "dratio", "turned")
    values = dict(
        zip(
            names,
            code.contact(xp_complex if np.iscomplexobj(t) else np, t, parameters, hoisted),
            strict=True,
        )
    )
    return values | {"a": hoisted[0]}


def joint(family: str, seed: int) -> float:
    return float(math.pi / pairs.parameters(family, seed)[-1])


def angles(family: str, seed: int, count: int = 40) -> Array:
    """Of a turn, none of them at a joint."""
    t = np.random.default_rng(seed).uniform(0, TURN, count)
    return t[np.abs(t - joint(family, seed)) > 1e-3]


def panels(family: str, seed: int, end: float = TURN) -> tuple[Array, Array]:
    """Nodes and weights of a quadrature from 0 that knows the joint and runs in pieces of a quarter
    turn.
    """
    edges = [0.0, *(k * TURN / 12 for k in range(1, 12)), joint(family, seed)]
    return gauss_points(np.array(sorted({min(edge, end) for edge in edges} | {end})), 120)


# --- closure and rotation
# ------------------------------------------------------------------------------


def closure_gap(family: str, seed: int, stretched: float = 1.0) -> float:
    t, weights = panels(family, seed)
    return abs(float(weights @ contact(family, seed, t, stretched)["ratio"]) - TURN)


@every_curve
def test_both_gears_turn_equally_per_cycle(family: str, seed: int) -> None:
    assert closure_gap(family, seed) < 1e-12
    assert contact(family, seed, np.array([TURN]))["turned"][0] == pytest.approx(TURN, abs=1e-12)


@pytest.mark.parametrize(
    ("family", "seed"), [case for case in pairs.EVERY_CURVE if case[0] != "sine"]
)
def test_a_centre_distance_off_by_a_millionth_does_not_close(family: str, seed: int) -> None:
    assert closure_gap(family, seed, OFF) > 1e-7


def rotation_gap(family: str, seed: int, terms: int | None = None) -> float:
    gaps = []
    for end in angles(family, seed, 8):
        t, weights = panels(family, seed, end)
        turned = contact(family, seed, np.array([end]), terms=terms)["turned"][0]
        gaps.append(turned - weights @ contact(family, seed, t)["ratio"])
    return float(np.abs(gaps).max())


@every_curve
def test_rotation_is_the_integral_of_the_ratio(family: str, seed: int) -> None:
    assert rotation_gap(family, seed) < 2e-12


@pytest.mark.parametrize(
    "family", [f for f, seed in pairs.EVERY_CURVE if seed == 1 and pairs.stage(f, 1).terms]
)
def test_series_tail_equals_error_of_shorter_series(family: str) -> None:
    parameters, terms = pairs.parameters(family, 1), pairs.stage(family, 1).terms
    series = np.abs(pairs.stage(family, 1).prologue(parameters=parameters)["hoisted"][1:, 0])
    assert series[-1] < SERIES_TOLERANCE
    short = int(np.argmax(series < 1e-5))
    assert 1e-8 < rotation_gap(family, 1, terms=short) < 1e-3
    assert terms > short


def test_series_of_three_lobes_is_not_cut_between_terms() -> None:
    """Only every third coefficient is there: the last one alone says nothing about the tail."""
    parameters = np.array([0.03, 1e-9, 0.0, 0.012, 1.0])
    stage = pairs.stage_of("fourier", parameters)
    series = np.abs(stage.prologue(parameters=parameters)["hoisted"][1:, 0])
    assert series[[0, 1, 3, 4]].max() < 1e-5 < series[[2, 5]].min()
    assert series[-3:].max() < SERIES_TOLERANCE


# --- rolling
# -------------------------------------------------------------------------------------------


def tangents(
    family: str, seed: int, t: Array, stretched: float
) -> tuple[NDArray[np.complex128], ...]:
    """Tangents dz/dt of gear and conjugate at the contact, both curves drawn in their own gears and
    laid there.
    """
    step = t + 1j * xp_complex.STEP
    contact_values = contact(family, seed, step, stretched)
    r, turned = contact_values["r"], contact_values["turned"]
    mate = contact_values["a"] - r
    gear = slope(r * np.cos(step)) + 1j * slope(r * np.sin(step))
    other = slope(-mate * np.cos(turned)) + 1j * slope(mate * np.sin(turned))
    return gear * np.exp(-1j * t), other * np.exp(1j * np.real(turned))


def slope(values: NDArray[np.complex128]) -> Array:
    return np.imag(values) / xp_complex.STEP


def rolling_gap(family: str, seed: int, stretched: float = 1.0) -> float:
    first, second = tangents(family, seed, angles(family, seed), stretched)
    return float((np.abs(first - second) / np.abs(first)).max())


@every_curve
def test_conjugates_roll_without_slip_on_a_common_tangent(family: str, seed: int) -> None:
    assert rolling_gap(family, seed) < 1e-11


@every_curve
def test_at_another_distance_they_do_not_roll(family: str, seed: int) -> None:
    if family != "sine":
        assert rolling_gap(family, seed, OFF) > 1e-7
        return
    wrong = contact(family, seed, angles(family, seed), OFF)
    assert np.abs(wrong["ratio"] - wrong["r"] / (wrong["a"] - wrong["r"])).max() > 1e-7


@every_curve
def test_rolled_arcs_are_equal(family: str, seed: int) -> None:
    for end in (joint(family, seed), 5.0, TURN):
        t, weights = panels(family, seed, end)
        first, second = (np.abs(tangent) for tangent in tangents(family, seed, t, 1.0))
        assert weights @ first == pytest.approx(weights @ second, rel=1e-12)


# --- exchange
# ------------------------------------------------------------------------------------------


def angle_at(family: str, seed: int, rotation: Array) -> Array:
    """The polar angles of the gear at which its conjugate has turned so far, by bisection."""
    low, high = np.zeros_like(rotation), np.full_like(rotation, TURN)
    for _ in range(55):
        middle = (low + high) / 2
        before = contact(family, seed, middle)["turned"] < rotation
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    return (low + high) / 2


def exchange_gap(family: str, seed: int, stretched: float = 1.0) -> float:
    """By how much the conjugate of the conjugate, drawn over the conjugate's own angle, misses the
    gear's rotation.
    """
    gaps = []
    for rotation in (1.0, 4.0):
        edges = np.array(sorted({0.0, min(joint(family, seed), rotation), rotation}))
        rotations, weights = gauss_points(edges, 120)
        at = contact(family, seed, angle_at(family, seed, rotations))
        mate, distance = at["a"] - at["r"], at["a"] * stretched
        total = weights @ (mate / (distance - mate))
        gaps.append(total - angle_at(family, seed, np.array([rotation]))[0])
    return float(np.abs(gaps).max())


@every_family
def test_the_conjugate_of_the_conjugate_is_the_gear(family: str) -> None:
    assert exchange_gap(family, 2) < 1e-10
    assert exchange_gap(family, 2, OFF) > 1e-7


@every_curve
def test_the_conjugate_is_deformed_by_the_same_coefficient(family: str, seed: int) -> None:
    """Its joint lies at pi/m of its own angle, and it is even about both joints in its own
    parameter.
    """
    m = pairs.parameters(family, seed)[-1]
    m2 = m / (2 * m - 1)
    parameters = np.array([0.3, 1.1, 2.9])
    first, second = (
        contact(family, seed, angle_at(family, seed, v))
        for v in (parameters / m, TURN - parameters / m2)
    )
    assert first["r"] == pytest.approx(second["r"], rel=1e-12)
    assert contact(family, seed, np.array([math.pi / m]))["turned"][0] == pytest.approx(
        math.pi / m, abs=1e-12
    )


# --- derivatives and curvature
# -------------------------------------------------------------------------


@every_curve
def test_derivatives_agree_with_complex_steps(family: str, seed: int) -> None:
    t = angles(family, seed)
    at = contact(family, seed, t + 1j * xp_complex.STEP)
    for value, derivative in (("r", "dr"), ("dr", "ddr"), ("ratio", "dratio"), ("turned", "ratio")):
        scale = np.abs(at[derivative]).max()
        assert slope(at[value]) == pytest.approx(
            np.real(at[derivative]), rel=1e-11, abs=3e-12 * scale
        )
    assert slope(at["r"]) != pytest.approx(1.001 * np.real(at["dr"]), rel=1e-5)


def drawn_curvatures(family: str, seed: int, t: mp.mpf) -> tuple[float, float]:
    """Of gear and conjugate at a polar angle, from their points by differences at 30 digits."""
    code, parameters = (
        model.array_module(f"curve_{family}"),
        [mp.mpf(float(p)) for p in pairs.parameters(family, seed)],
    )
    hoisted = code.prologue(xp_mpmath, parameters, pairs.stage(family, seed).terms)

    def places(s: mp.mpf) -> tuple[mp.mpc, mp.mpc]:
        r, _, _, _, _, turned = code.contact(xp_mpmath, s, parameters, hoisted)
        return r * mp.expj(s), (hoisted[0] - r) * mp.expj(turned)

    gaps = []
    for index in (0, 1):
        first, second = (mp.diff(lambda s, i=index: places(s)[i], t, n) for n in (1, 2))
        gaps.append(float(mp.im(mp.conj(first) * second) / abs(first) ** 3))
    return gaps[0], gaps[1]


@every_family
def test_curvatures_are_those_of_the_drawn_curves(family: str) -> None:
    """On both segments; the array code is differentiated at 30 digits, its series cut at 1e-12."""
    parameters, stage = pairs.parameters(family, 1), pairs.stage(family, 1)
    hoisted, m = stage.prologue(parameters=parameters)["hoisted"], parameters[-1]
    with mpmath.workdps(30):
        for u in (0.4, 2.0):
            at = {
                name: row[0, 0]
                for name, row in stage.curvature(
                    u=[u], parameters=parameters, hoisted=hoisted
                ).items()
            }
            for segment, t in (("first", u / m), ("second", TURN - u * (2 * m - 1) / m)):
                gear, mate = drawn_curvatures(family, 1, mp.mpf(t))
                assert at[f"gear_{segment}"] == pytest.approx(gear, rel=1e-8)
                assert at[f"conjugate_{segment}"] == pytest.approx(mate, rel=1e-8)
                assert at[f"conjugate_{segment}"] != pytest.approx(gear, rel=1e-8)


def convexity(family: str, parameters: Array) -> float:
    """The closed form that is positive if and only if the deformed curve is convex."""
    return float(
        Kernel(families.load_functions(family).convexity())(parameters=parameters)["convex"][0, 0]
    )


def hollowness(family: str, parameters: Array) -> float:
    """The gear's least curvature over both segments, per curvature of a circle of its size."""
    stage = pairs.stage_of(family, parameters)
    hoisted = stage.prologue(parameters=parameters)["hoisted"]

    def bend(u: Array) -> Array:
        curvatures = stage.curvature(u=u, parameters=parameters, hoisted=hoisted)
        return np.minimum(curvatures["gear_first"][0], curvatures["gear_second"][0])

    return extrema.find_minimum(bend, np.linspace(0, np.pi, 181)).value * parameters[0]


CLOSED = [
    f
    for f in sorted({f for f, _ in pairs.EVERY_CURVE})
    if hasattr(families.load_functions(f), "convexity")
]


ALWAYS_CONVEX = {("ellipse", 1.0), ("ellipse", 1.3), ("eccentric_circle", 1.0)}


@pytest.mark.parametrize(
    "m", [0.72, *(pytest.param(m, marks=pytest.mark.long) for m in (1.0, 2.2)), 1.3]
)
@pytest.mark.parametrize("family", CLOSED)
def test_convexity_limits_are_where_the_least_curvature_vanishes(family: str, m: float) -> None:
    def at(swing: float) -> Array:
        return pairs.sizing(family).parameters(Size(0.03, swing, m))

    if (family, m) in ALWAYS_CONVEX:
        assert convexity(family, at(0.99)) > 0
        assert hollowness(family, at(0.99)) > 0.01
        return
    limit = brentq(lambda swing: convexity(family, at(swing)), 0.02, 0.995, xtol=1e-13)
    assert abs(hollowness(family, at(limit))) < 1e-7
    assert hollowness(family, at(limit * 0.99)) > 1e-4
    assert hollowness(family, at(limit * 1.003)) < -1e-4


def test_fourier_becomes_concave_by_curvature() -> None:
    assert CLOSED == ["eccentric_circle", "ellipse", "limacon", "sine"]

    def hollow(swing: float, *shape: float) -> float:
        return hollowness(
            "fourier", pairs.sizing("fourier").parameters(Size(0.03, swing, 1.0, shape))
        )

    limits = [
        brentq(hollow, 0.2, 0.9, args=shape, xtol=1e-9)
        for shape in ((0.0, 0.0), (0.1, 0.0), (-0.1, 0.0))
    ]
    assert limits[0] == pytest.approx(2 / math.sqrt(7), abs=1e-7)
    assert limits[1] > limits[0] + 0.01
    assert limits[2] < limits[0] - 0.01


# --- size
# ----------------------------------------------------------------------------------------------


@every_curve
def test_sized_curve_has_requested_size(family: str, seed: int) -> None:
    """Mean radius over the polar angle and swing of the ratio, from the deformed curve itself."""
    size = pairs.size(family, seed)
    t, weights = panels(family, seed)
    at = contact(family, seed, t)
    ends = contact(family, seed, np.array([0.0, joint(family, seed)]))["ratio"]
    assert weights @ at["r"] / TURN == pytest.approx(size.mean_radius, rel=1e-12)
    assert (ends[0] - ends[1]) / (ends[0] + ends[1]) == pytest.approx(size.swing, rel=1e-12)
    assert ends[1] <= at["ratio"].min() <= at["ratio"].max() <= ends[0]
    back = pairs.sizing(family).size(pairs.parameters(family, seed))
    assert [back.mean_radius, back.swing] == pytest.approx(
        [size.mean_radius, size.swing], rel=1e-13
    )


@every_curve
def test_the_swing_is_the_same_whichever_gear_drives(family: str, seed: int) -> None:
    ratio = contact(family, seed, np.array([0.0, joint(family, seed)]))["ratio"]
    first, second = ((high - low) / (high + low) for high, low in (ratio, 1 / ratio[::-1]))
    assert first == pytest.approx(second, rel=1e-13)


@every_family
def test_small_swings_are_the_same_in_every_family(family: str) -> None:
    """To first order in the swing s every pair is r = mean (1 + s/2 cos u) at twice the mean
    radius.
    """
    for swing, bound in ((1e-3, 1e-6), (1e-5, 1e-10)):
        parameters = pairs.sizing(family).parameters(Size(0.03, swing))
        stage = pairs.stage_of(family, parameters)
        hoisted = stage.prologue(parameters=parameters)["hoisted"]
        t = np.linspace(0, TURN, 30)
        at = stage.contact(t=t, parameters=parameters, hoisted=hoisted)
        assert at["r"][0] / 0.03 == pytest.approx(1 + swing / 2 * np.cos(t), abs=bound)
        assert at["ratio"][0] == pytest.approx(1 + swing * np.cos(t), abs=bound)
        assert hoisted[0, 0] / 0.06 == pytest.approx(1, abs=bound)


BAD_CURVES = {
    "limacon": ([0.03, 0.03, 1.2], "b_mm = 30: it must be less than l"),
    "sine": ([0.06, 1.0, 1.2], "c = 1: it must be less than 1"),
    "fourier": (
        [0.03, 0.02, -0.02, 0.0, 1.2],
        "c1_mm = 20.* such that the radius at u = pi is greater than 0",
    ),
}


@pytest.mark.parametrize("family", BAD_CURVES)
def test_parameters_outside_the_domain_are_named(family: str) -> None:
    parameters, sentence = BAD_CURVES[family]
    with pytest.raises(GeometryError, match=sentence):
        pairs.stage(family, 1).check_parameters(
            StageCandidate(np.array(parameters), lambda name: name)
        )


def test_a_radius_below_zero_between_the_joints_is_named() -> None:
    parameters = np.array([0.03, 0.005, 0.04, 0.0, 1.2])
    stage = pairs.stage_of("fourier", parameters)
    stage.check_parameters(StageCandidate(parameters, lambda name: name))
    with pytest.raises(GeometryError, match=r"r = -10.* mm at t = .* deg: it must be between 0"):
        stage.check_radius(StageCandidate(parameters, lambda name: name))


# --- devices
# -------------------------------------------------------------------------------------------

SOME_PAIRS = [pair for i, pair in enumerate(pairs.PAIRS) if i % 6 == 1 or i == 20]
"""Every family once in each stage, beside another."""
every_pair = pytest.mark.parametrize(("first", "second"), sampled(pairs.PAIRS, SOME_PAIRS))


def device_gap(device: Device, moving: kinematics.Machine) -> float:
    phi = np.random.default_rng(5).uniform(0, TURN, 40)
    totals = model.cycle(device, phi).totals
    x, y = momentum_rate(moving, phi)
    return float(
        np.max(np.abs([totals["F_support_x"] - x, totals["F_support"] - y - weight(moving)]))
    )


@every_pair
def test_every_pair_of_families_keeps_momentum(first: str, second: str) -> None:
    """Against kinematics that share nothing with the generated code, at random carrier angles."""
    assert device_gap(Device(pairs.machine(first, second)), pairs.machine(first, second)) < 1e-10


@every_family
def test_another_swing_breaks_momentum(family: str) -> None:
    """In stage 1 of the machine that moves: the second parameter is the one that swings, in every
    family.
    """
    machine = pairs.machine(family, family)
    name = Device(machine).names[5]
    moved = machine.with_numbers({f"design.{name}": machine.design[name] * 1.001})
    assert device_gap(Device(machine), moved) > 1e-4


@every_pair
def test_the_mean_support_force_is_the_weight(first: str, second: str) -> None:
    machine = pairs.machine(first, second)
    device = Device(machine)
    joints = np.mod([*of_side(machine), *of_teeth(device)], np.pi)
    edges = np.unique([0, *joints, np.pi])
    phi, weights = gauss_points(edges, 24)
    force = model.cycle(device, phi).totals["F_support"]
    assert weights @ force / np.pi == pytest.approx(weight(machine), abs=1e-8)
    assert np.ptp(force) > 1
    assert abs(force.mean() - weight(machine)) > 1e-5


@pytest.mark.parametrize(("first", "second"), SOME_PAIRS)
def test_gradients_agree_with_complex_steps_in_every_family(first: str, second: str) -> None:
    device, rng = Device(pairs.machine(first, second)), np.random.default_rng(6)
    for _ in range(2):
        gradient, error = errors(device, *smooth_point(device, rng))
        assert np.abs(error).max() <= TOLERANCE * np.abs(gradient).max()


@pytest.mark.parametrize(
    "some", [SOME_PAIRS, pytest.param(pairs.PAIRS, marks=pytest.mark.long)], ids=len
)
def test_devices_of_different_families_are_different(some: list[tuple[str, str]]) -> None:
    phi = np.linspace(0, TURN, 50)
    forces = np.array(
        [model.cycle(Device(pairs.machine(*pair)), phi).totals["F_support"] for pair in some]
    )
    gaps = np.abs(forces[:, None] - forces).max(axis=2)[np.triu_indices(len(forces), 1)]
    assert gaps.min() > 1e-3
