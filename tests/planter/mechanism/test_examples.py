"""The examples of the guide: short, derived as they stand, held against closed forms and energies
written down here.
"""

import numpy as np
import pytest
import scipy.integrate
import scipy.linalg
import scipy.optimize

from planter.mechanism.cycle import compute_cycle
from planter.mechanism.model import Model
from planter.mechanism.motion import eigenvalues, equilibrium
from tests.support import own

MOST_LINES = 130
G = 9.81


@pytest.mark.parametrize("path", sorted(own.EXAMPLES.glob("*.py")), ids=lambda path: path.stem)
def test_an_example_is_short(path: object) -> None:
    assert len(path.read_text(encoding="utf-8").splitlines()) <= MOST_LINES  # type: ignore[attr-defined]


def test_without_friction_the_cam_carries_mass_weight_and_spring() -> None:
    own_model = Model(own.machine("cam_follower", mu=0.0))
    phi = np.radians(np.arange(0.0, 360.0, 5.0))
    values, omega = own_model(phi), 240 * np.pi / 30
    lift, slope, bend = 0.007 * (1 - np.cos(phi)), 0.007 * np.sin(phi), 0.007 * np.cos(phi)
    push = 0.65 * (G + bend * omega**2) + 22 + 1800 * lift
    assert values["N_cam"] == pytest.approx(
        push * np.hypot(slope, 0.038 + lift) / (0.038 + lift), rel=1e-12
    )
    assert values["M_in"] == pytest.approx(push * slope, abs=1e-12)


def test_roller_lifts_off_above_computed_speed() -> None:
    """At the top of the lift: m (g - h omega^2 / 2) + F_0 + k h = 0."""
    rpm = np.sqrt(2 / 0.014 * (G + (22 + 1800 * 0.014) / 0.65)) * 30 / np.pi
    top = np.array([np.pi])
    below, above = (
        Model(own.machine("cam_follower", omega_rpm=rpm * share))(top)["N_cam"][0]
        for share in (0.999, 1.001)
    )
    assert below > 0 > above


def lifting(**values: float) -> list[tuple[str, float]]:
    return [
        (w.name, w.phi_deg)
        for w in compute_cycle(Model(own.machine("cam_follower", **values))).result.warnings
    ]


def test_a_turn_warns_where_the_cam_would_have_to_pull() -> None:
    """Without friction the force vanishes where m (g + h omega^2 cos(phi) / 2) + F_0 + k h (1 -
    cos(phi)) / 2 does.
    """
    assert lifting() == []
    omega = 1100 * np.pi / 30
    off = np.degrees(
        np.arccos(-(0.65 * G + 22 + 1800 * 0.007) / (0.65 * 0.007 * omega**2 - 1800 * 0.007))
    )
    (warning,) = compute_cycle(
        Model(own.machine("cam_follower", mu=0.0, omega_rpm=1100))
    ).result.warnings
    assert warning.phi_deg == pytest.approx(off, abs=1e-6)
    assert f"would have to pull from {off:.6g} to {360 - off:.6g} deg" in warning.message


def test_pull_between_samples_is_reported() -> None:
    rpm = np.sqrt(2 / 0.014 * (G + (22 + 1800 * 0.014) / 0.65)) * 30 / np.pi
    model = Model(own.machine("cam_follower", mu=0.0, omega_rpm=rpm * 1.00001))
    assert model(np.radians([179.0, 181.0]))["N_cam"].min() > 0
    assert [w.phi_deg for w in compute_cycle(model, 45).result.warnings] == [
        pytest.approx(179.6, abs=0.4)
    ]
    assert lifting(F_0_N=-900.0) == [("contact_would_pull", 0.0)]


def ellipse(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pitch radius of the example's gears about a focus, and how fast the mate turns for it, in
    metres.
    """
    r = 0.021 * (1 - 0.14**2) / (1 - 0.14 * np.cos(t))
    return r, r / (0.042 - r)


def test_the_planet_turns_as_pitch_curves_roll() -> None:
    """Both stages integrated from the ratio of the radii; both shafts' torques by hand
    (Newton-Euler).
    """
    phi = np.linspace(0, 2 * np.pi, 361)
    values = Model(own.machine("planetary_train"))(phi)
    start = [0.0, 0.0, values["t2"][0]]
    path = scipy.integrate.solve_ivp(
        lambda angle, y: [
            (radius := ellipse(np.radians(20) + angle)[1]),
            -ellipse(y[2])[1] * radius,
            -radius,
        ],
        (0, 2 * np.pi),
        start,
        t_eval=phi,
        rtol=1e-11,
        atol=1e-12,
    )
    assert values["psi"] == pytest.approx(path.y[0], abs=1e-8)
    assert values["chi"] == pytest.approx(path.y[1], abs=1e-8)
    assert path.y[0][-1] == pytest.approx(2 * np.pi, abs=1e-8)
    heading = phi + values["chi"] - np.radians(60)
    push = 0.64 * (values["a_planet_y"] + G), 0.64 * values["a_planet_x"]
    torque = 0.0011 * values["chi_ddot"] + 0.042 * (
        np.cos(heading) * push[0] - np.sin(heading) * push[1]
    )
    assert values["M_Q"] == pytest.approx(torque, abs=1e-12)


def test_non_rolling_pitch_curves_break_a_law() -> None:
    text = (
        (own.EXAMPLES / "planetary_train.py").read_text().replace("2 * atan2(q.k", "2 * atan2(-q.k")
    )
    laws = {
        law.law: law.violation
        for law in compute_cycle(Model(own.machine(text, "planetary_train")), 90).result.laws
    }
    assert laws["sliding of the pitch curves at P, y, which vanishes"] > 0.01
    assert laws["sliding of the pitch curves at Q, y, which vanishes"] > 0.01


def inertia(elbow: float) -> np.ndarray:
    """Of a planar manipulator of two arms (Craig, Introduction to robotics, 3rd ed., section 6.7,
    with centroids).
    """
    m1, m2, l1, c1, c2, j1, j2 = 3.2, 1.9, 0.42, 0.19, 0.15, 0.052, 0.027
    first, cross = m1 * c1**2 + j1 + m2 * (l1**2 + c2**2) + j2, m2 * l1 * c2 * np.cos(elbow)
    return np.array(
        [[first + 2 * cross, m2 * c2**2 + j2 + cross], [m2 * c2**2 + j2 + cross, m2 * c2**2 + j2]]
    )


def pulls(angles: np.ndarray) -> np.ndarray:
    shoulder, elbow = angles
    low = 1.9 * G * 0.15 * np.cos(shoulder + elbow)
    motors = np.array([60, 25]) * (np.radians([-40, 75]) - angles)
    return motors - np.array([(3.2 * 0.19 + 1.9 * 0.42) * G * np.cos(shoulder) + low, low])


def test_manipulator_rest_and_swing_equal_matrices() -> None:
    dynamics = own.dynamics("manipulator")
    rest = equilibrium(dynamics)
    expected = scipy.optimize.fsolve(pulls, np.radians([-40, 75]), xtol=1e-14)
    assert rest[:2] == pytest.approx(expected, abs=1e-10)
    step = 1e-6
    stiff = -np.array(
        [(pulls(expected + d) - pulls(expected - d)) / (2 * step) for d in step * np.eye(2)]
    ).T
    flow = np.block(
        [
            [np.zeros((2, 2)), np.eye(2)],
            [-np.linalg.solve(inertia(expected[1]), np.hstack([stiff, np.diag([6, 1.8])]))],
        ]
    )
    roots = eigenvalues(dynamics, rest)
    assert np.sort_complex(roots) == pytest.approx(
        np.sort_complex(scipy.linalg.eigvals(flow)), abs=1e-6
    )


def test_manipulator_dampers_dissipate_supplied_work() -> None:
    times = np.linspace(0, 1, 2001)
    run = own.dynamics("manipulator").run(times, 1e-10)
    power = run.results["M_1"] * run.states[2] + run.results["M_2"] * run.states[3]
    gained = scipy.integrate.cumulative_simpson(power, x=times, initial=0)
    energy = run.results["kinetic"] + run.results["potential"]
    assert energy - energy[0] == pytest.approx(gained, abs=1e-4)
