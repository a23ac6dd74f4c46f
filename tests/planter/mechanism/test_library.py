"""Machines of the library, held against closed forms, numbers in print, and positions by
intersecting circles.
"""

import numpy as np
import pytest
import scipy.integrate
import scipy.optimize
import scipy.special

from derive import Mechanism, Z
from derive.mechanics.statement import MechanismError
from derive.quantity import Quantity
from planter.engine.summary import PiecewiseCycle, build_rows
from planter.kernels import Array
from planter.mechanism.cycle import compute_cycle
from planter.mechanism.model import Model
from tests.support import own

MACHINES = [
    "cam_follower",
    "crank_rocker",
    "eccentric_train",
    "geneva_wheel",
    "geared_five_bar",
    "hay_baler",
    "hooke_joint",
    "lift_arm",
    "planetary_train",
    "radial_pump",
    "rssr",
    "scotch_yoke",
    "slider_crank",
    "stephenson_six_bar",
    "swash_plate",
    "toggle_press",
    "transplanting_arm",
    "watt_six_bar",
]
GEARED = ["internal_gears", "planetary_gear", "rack_press"]
TURN = np.linspace(0.05, 6.2, 83)
STEP = 1e-3
PHI, OMEGA = Quantity("phi", "rad", "crank", "test"), Quantity("omega", "rad/s", "speed", "test")
MASS, LENGTH = Quantity("m", "kg", "mass", "test"), Quantity("l", "m", "rod", "test")


def evaluate(name: str, angles: Array = TURN, **values: float) -> dict[str, Array]:
    return Model(own.machine(name, **values))(angles)


def differentiate(values: Array) -> tuple[Array, Array]:
    """Return first and second derivatives (n,) from values (5, n) at angles -2 to 2 steps away."""
    a, b, c, d, e = values
    return (a - 8 * b + 8 * d - e) / (12 * STEP), (-a + 16 * b - 30 * c + 16 * d - e) / (
        12 * STEP**2
    )


def angles_around(angles: Array) -> Array:
    return angles + STEP * np.arange(-2, 3)[:, None]


def intersect_circles(first: Array, second: Array, radii: tuple[float, float], side: int) -> Array:
    """Return the point (n,), as a complex number, at distances from two points, left of their line
    or right of it.
    """
    line = second - first
    distance = np.abs(line)
    projection = (distance**2 + radii[0] ** 2 - radii[1] ** 2) / (2 * distance)
    height = np.sqrt(radii[0] ** 2 - projection**2)
    result: Array = first + line / distance * (projection + side * 1j * height)
    return result


@pytest.mark.parametrize("name", [*MACHINES, *GEARED])
def test_cycle_satisfies_laws(name: str) -> None:
    laws = compute_cycle(Model(own.machine(name)), 90).result.laws
    assert {"W", "N", "N m"} <= {law.unit for law in laws} <= {"W", "N", "N m", "1", "m/s"}
    assert max(law.violation for law in laws) < (1e-12 if name in GEARED else 1e-10)
    rolling = sum("sliding of the pitch curves" in law.law for law in laws)
    assert rolling >= 2 or name not in GEARED


def test_scotch_yoke_is_harmonic() -> None:
    values, speed = evaluate("scotch_yoke"), 240 * np.pi / 30
    assert values["s"] == pytest.approx(0.04 * np.cos(TURN), abs=1e-15)
    load = 80 - 1.2 * 0.04 * speed**2 * np.cos(TURN)
    assert values["M_in"] == pytest.approx(-0.04 * np.sin(TURN) * load, abs=1e-12)


def test_cam_follower_agrees_with_print() -> None:
    """R.

    L. Norton, Cam design and manufacturing handbook: a harmonic rise has the factors 1.571 and
    4.935.
    """
    values, pace = evaluate("cam_follower", np.array([0.0, np.pi / 2])), 240 * np.pi / 30 / np.pi
    assert values["s_dot"][1] / (0.014 * pace) == pytest.approx(1.571, abs=5e-4)
    assert values["s_ddot"][0] / (0.014 * pace**2) == pytest.approx(4.935, abs=5e-4)


def test_crank_rocker_follows_intersected_circles() -> None:
    """By Grashof's rule the crank turns in full; the rocker's angle is that of Freudenstein's
    equation, and a constant load does no work over a cycle.
    """
    values, data = evaluate("crank_rocker"), own.file("crank_rocker").values
    a, b, c, d = (data[f"{name}_mm"] / 1000 for name in "abcd")
    assert a + b <= c + d
    pin = a * np.exp(1j * TURN)
    joint = intersect_circles(pin, np.full(TURN.shape, d + 0j), (b, c), 1)
    assert values["gamma"] == pytest.approx(np.angle(joint - d), abs=1e-12)
    assert values["beta"] == pytest.approx(np.angle(joint - pin), abs=1e-12)
    gamma = values["gamma"]
    shape = d / a * np.cos(gamma) - d / c * np.cos(TURN)
    shape += (a**2 - b**2 + c**2 + d**2) / (2 * a * c)
    assert shape == pytest.approx(np.cos(TURN - gamma), abs=1e-12)
    work = compute_cycle(Model(own.machine("crank_rocker")), 90).result.quantities["M_in_Nm"].mean
    assert work == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("start", [5.0, 60.0, 150.0])
def test_undamped_pendulum_has_the_period_of_the_elliptic_integral(start: float) -> None:
    pendulum = own.dynamics("pendulum", k_N_m_s=0.0, start_deg=start)
    data = pendulum.file.values
    arm, mass = data["l_mm"] / 1000, data["m_kg"]
    share = (data["J_kg_m2"] + mass * arm**2) / (mass * data["g_m_s2"] * arm)
    period = 4 * np.sqrt(share) * scipy.special.ellipk(np.sin(np.radians(start) / 2) ** 2)
    times = period * np.array([0.0, 0.25, 0.5, 1.0])
    angles = pendulum.run(times, 1e-11, pendulum.start()).states[0]
    assert angles == pytest.approx(np.radians(start) * np.array([1, 0, -1, 1]), abs=1e-6)
    total = pendulum.run(times, 1e-11, pendulum.start()).results
    assert np.ptp(total["kinetic"] + total["potential"]) < 1e-9


def test_damper_of_the_pendulum_takes_its_energy() -> None:
    pendulum = own.dynamics("pendulum")
    run = pendulum.run(np.linspace(0, 3, 3001), 1e-11, pendulum.start())
    power = run.results["M_d"] * run.states[1]
    total = run.results["kinetic"] + run.results["potential"]
    assert total[-1] - total[0] == pytest.approx(
        scipy.integrate.simpson(power, x=run.times), rel=1e-6
    )
    assert power.max() <= 0


@pytest.mark.parametrize("bend", [10.0, 30.0])
def test_hooke_joint_follows_closed_form(bend: float) -> None:
    """The ratio lies between the cosine of the angle between the shafts and its inverse."""
    values, beta, speed = evaluate("hooke_joint", beta_deg=bend), np.radians(bend), 540 * np.pi / 30
    shape = 1 - np.sin(beta) ** 2 * np.cos(TURN) ** 2
    ratio, bending = (
        np.cos(beta) / shape,
        -np.cos(beta) * np.sin(beta) ** 2 * np.sin(2 * TURN) / shape**2,
    )
    assert values["psi_dot"] == pytest.approx(ratio * speed, rel=1e-10)
    assert values["M_in"] == pytest.approx(ratio * (100 + 0.05 * bending * speed**2), rel=1e-9)
    extremes = evaluate("hooke_joint", np.array([0.0, np.pi / 2]), beta_deg=bend)["psi_dot"] / speed
    assert extremes == pytest.approx([1 / np.cos(beta), np.cos(beta)], rel=1e-12)


def test_geneva_wheel_agrees_with_print() -> None:
    """I.

    I. Artobolevsky, Mechanisms in modern engineering design, three-slot inverse Geneva wheel:
    0.464, 1.729.

    The second number, the acceleration where the pin enters, is tan 60 degrees: 1.732.
    """
    speed, entry = 60 * np.pi / 30, np.radians(30)
    values = evaluate(
        "geneva_wheel", np.array([np.pi, entry + 1e-9, entry / 2, 2 * np.pi - entry / 2])
    )
    assert values["psi_dot"][0] / speed == pytest.approx(0.464, abs=5e-4)
    assert values["psi_ddot"][1] / speed**2 == pytest.approx(1.729, abs=4e-3)
    assert values["psi_ddot"][1] / speed**2 == pytest.approx(np.tan(np.radians(60)), abs=1e-7)
    assert list(values["psi_dot"][2:]) == list(values["M_in"][2:]) == [0.0, 0.0], (
        "the wheel rests for 60 degrees"
    )
    moving = evaluate("geneva_wheel")
    assert moving["M_in"] == pytest.approx(
        0.004 * moving["psi_ddot"] * moving["psi_dot"] / speed, abs=1e-12
    )


def test_swash_plate_bears_oil_and_inertia() -> None:
    values, slope, speed = evaluate("swash_plate"), np.tan(np.radians(18)), 1500 * np.pi / 30
    load = 900 - 0.08 * 0.035 * slope * speed**2 * np.cos(TURN)
    assert values["N_plate"] == pytest.approx(load / np.cos(np.radians(18)), rel=1e-12)
    assert values["M_in"] == pytest.approx(-0.035 * slope * np.sin(TURN) * load, abs=1e-10)


def find_rocker_angle(angle: float) -> float:
    """The angle at which the rod of the RSSR has its length, by a bracketed root."""

    def excess(psi: float) -> float:
        rocker = np.array([60.0, 170.0 - 110 * np.sin(psi), -30 + 110 * np.cos(psi)])
        return float(np.linalg.norm(rocker - [40 * np.cos(angle), 40 * np.sin(angle), 0.0]) - 210)

    return float(scipy.optimize.brentq(excess, -1.2, 1.2, xtol=1e-15))


def test_rssr_agrees_with_bracketed_root() -> None:
    values, speed, angles = evaluate("rssr"), 120 * np.pi / 30, angles_around(TURN)
    positions = np.vectorize(find_rocker_angle)(angles)
    slope, bend = differentiate(positions)
    assert values["psi"] == pytest.approx(positions[2], abs=1e-12)
    assert values["M_in"] == pytest.approx(slope * (6 + 0.006 * bend * speed**2), abs=1e-6)


def test_watt_six_bar_balances_virtual_work() -> None:
    angles = angles_around(TURN)
    crank = 0.04 * np.exp(1j * angles)
    pin = intersect_circles(crank, np.full_like(crank, 0.1), (0.12, 0.08), 1)
    arm = 0.1 - 0.06j * (pin - 0.1) / 0.08
    out = np.unwrap(
        np.angle(intersect_circles(arm, np.full_like(arm, 0.23), (0.14, 0.09), 1) - 0.23), axis=0
    )
    values = evaluate("watt_six_bar", omega_rpm=1e-4)
    assert np.cos(values["chi"] - out[2]) == pytest.approx(1.0, abs=1e-12)
    lift = differentiate((crank + pin).imag / 2)[0]
    assert values["M_in"] == pytest.approx(4 * differentiate(out)[0] + 0.5 * 9.81 * lift, abs=1e-8)


def test_stephenson_six_bar_balances_virtual_work() -> None:
    angles = angles_around(TURN)
    crank = 0.04 * np.exp(1j * angles)
    pin = intersect_circles(crank, np.full_like(crank, 0.1), (0.12, 0.08), 1)
    point = crank + (0.075 + 0.06j) * (pin - crank) / 0.12
    shaft = 0.21 + 0.04j
    joint = intersect_circles(point, np.full_like(point, shaft), (0.15, 0.12), 1)
    out = np.unwrap(np.angle(joint - shaft), axis=0)
    values = evaluate("stephenson_six_bar", omega_rpm=1e-4)
    assert np.cos(values["chi"] - out[2]) == pytest.approx(1.0, abs=1e-12)
    assert values["M_in"] == pytest.approx(
        4 * differentiate(out)[0] + 0.5 * 9.81 * differentiate(point.imag)[0], abs=1e-8
    )


def test_hay_baler_balances_virtual_work() -> None:
    """The motor bears the hay, the rod's weight and, over a stroke, the work up to the dead
    centre.
    """
    angles = angles_around(TURN)
    crank = 0.36 * np.exp(1j * angles)
    tilt = np.arcsin((-0.06 - crank.imag) / 1.0)
    place = crank.real + np.cos(tilt)
    slope = differentiate(place)[0]
    hay = np.where(slope > 0, 6e4 * np.maximum((place[2] - 1) / 0.35, 0) ** 3, 0)
    assert np.count_nonzero(hay) > 10
    values = evaluate("hay_baler", omega_rpm=1e-4)
    assert values["F_hay"] == pytest.approx(hay, abs=1e-6)
    lift = differentiate(crank.imag + 0.42 * np.sin(tilt))[0]
    assert values["M_in"] == pytest.approx(hay * slope + 32 * 9.81 * lift, abs=1e-5)


def test_mean_torque_of_hay_baler_is_exact() -> None:
    """The work of a stroke is that of the hay up to the dead centre, where its force drops to
    zero.
    """
    machine, farthest = own.machine("hay_baler"), np.sqrt(1.36**2 - 0.06**2)
    cycle = PiecewiseCycle(machine, build_rows(machine))
    stroke = cycle.motor("M_in").mean_Nm
    assert stroke == pytest.approx(
        6e4 * 0.35 / 4 * ((farthest - 1) / 0.35) ** 4 / (2 * np.pi), rel=1e-12
    )
    named = 'hay = m.report("F_hay", "N", "force of the hay", Piecewise('
    text = (
        (own.EXAMPLES / "hay_baler.py")
        .read_text(encoding="utf-8")
        .replace(named, "hay = (Piecewise(")
    )
    other = own.machine(text, "hay_baler")
    assert PiecewiseCycle(other, build_rows(other)).motor("M_in").mean_Nm == pytest.approx(
        stroke, rel=1e-12
    )
    drop = next(shock for shock in cycle.shocks() if shock.quantity == "F_hay")
    assert np.radians(drop.phi_deg) == pytest.approx(2 * np.pi - np.arcsin(0.06 / 1.36), abs=1e-12)
    assert [drop.before, drop.after] == pytest.approx(
        [6e4 * ((farthest - 1) / 0.35) ** 3, 0.0], rel=1e-9
    )


def gear_ratio(driver: float, mate: float) -> float:
    """The ratio of two eccentric involute gears by the law of gearing.

    The line of action touches both base circles from different sides; where it crosses the line of
    the shafts lies the pitch point.
    """
    distance, eccentricity = 42.0, 3.0
    base = distance / 2 * np.cos(np.radians(20))
    first, second = eccentricity * np.exp(1j * driver), distance + eccentricity * np.exp(1j * mate)
    separation = abs(second - first)
    normal = (second - first) / separation * np.exp(1j * np.arccos(2 * base / separation))
    foot = first + base * normal
    pitch = foot.real + foot.imag * normal.imag / normal.real
    return float(-pitch / (distance - pitch))


def test_eccentric_train_follows_law_of_gearing() -> None:
    """The angles agree with the integral of the ratio from where the long side of one gear meets
    the short side.
    """

    def integrate(angles: Array) -> Array:
        """Return the mate's angle (n,) at angles of the driver (n,)."""
        solution = [
            scipy.integrate.solve_ivp(
                lambda t, u: [gear_ratio(t, u[0])],
                (0, angle),
                [0.0],
                "DOP853",
                rtol=1e-12,
                atol=1e-13,
            ).y[0, -1]
            for angle in angles
        ]
        return np.array(solution)

    phase = TURN[::9]
    values, bend = evaluate("eccentric_train", phase), np.radians(-50)
    middle = integrate(np.radians(20) - phase)
    assert values["psi"] == pytest.approx(middle, abs=1e-10)
    assert values["chi"] == pytest.approx(integrate(middle - bend), abs=1e-10)
    slow, neighbours = evaluate("eccentric_train", phase, omega_rpm=1e-4), angles_around(phase)
    angles = evaluate("eccentric_train", neighbours.ravel())["chi"].reshape(neighbours.shape)
    outwards = neighbours + bend
    shaft = 0.042 * (np.sin(neighbours) + np.sin(outwards))
    lift = 0.64 * (
        shaft + 0.042 * np.sin(outwards + angles - np.radians(30))
    ) + 0.21 * 0.042 * np.sin(neighbours)
    assert slow["M_in"] == pytest.approx(9.81 * differentiate(lift)[0], abs=1e-7)


def test_eccentric_train_without_eccentricity_is_round() -> None:
    """Round equal gears: the middle gear turns twice as fast as the carrier, and the planet
    translates.
    """
    values = evaluate("eccentric_train", e_mm=0.0)
    assert values["psi"] == pytest.approx(TURN - np.radians(20), abs=1e-12)
    assert values["chi"] == pytest.approx(np.radians(-50 + 20) - TURN, abs=1e-12)


def test_lift_arm_balances_virtual_work() -> None:
    """The cylinder's pull is the weight's by the ratio of their speeds, with the inertia of the
    arm.
    """
    phase, speed = np.linspace(0.3, 2.8, 41), 6 * np.pi / 30
    angles = angles_around(phase)
    length = 0.52 + 0.08 * (1 - np.cos(angles))
    base, pin = np.hypot(0.12, 0.45), 0.3
    arm = np.arccos((base**2 + pin**2 - length**2) / (2 * base * pin)) - np.arctan2(0.45, 0.12)
    slope, bend = differentiate(arm)
    values = evaluate("lift_arm", phase)
    assert values["theta"] == pytest.approx(arm[2], abs=1e-12)
    moment = 180 * (9.81 * 0.8 * np.cos(arm[2]) + 0.8**2 * bend * speed**2) + 12 * bend * speed**2
    assert -values["F_cylinder"] * differentiate(length)[0] == pytest.approx(
        moment * slope, rel=1e-7
    )
    assert values["P_F_cylinder"] == pytest.approx(moment * slope * speed, rel=1e-7)


def test_toggle_press_balances_virtual_work() -> None:
    angles = angles_around(TURN)
    crank = -0.34 - 0.23j + 0.05 * np.exp(1j * angles)
    knee = intersect_circles(crank, np.zeros_like(crank), (0.3, 0.25), -1)
    ram = -knee.imag + np.sqrt(0.25**2 - knee.real**2)
    values = evaluate("toggle_press", omega_rpm=1e-4)
    assert values["s"] == pytest.approx(ram[2], abs=1e-12)
    assert values["M_in"] == pytest.approx((5000 - 12 * 9.81) * differentiate(ram)[0], abs=1e-6)


def test_rod_between_balls_spins_freely() -> None:
    m = Mechanism("strut", angle=PHI, speed=OMEGA, spatial=True)
    crank = m.frame("crank", PHI, Z)
    rod, end = (
        m.body("rod", crank, MASS, m.point("S", m.O, crank, LENGTH / 2)),
        m.point("E", m.O, crank, LENGTH),
    )
    m.ball("A", rod, m.ground, m.O)
    m.ball("B", rod, m.ground, end)
    with pytest.raises(MechanismError, match=r"rod spins freely about the line from O to E"):
        m.system()
