"""Examples whose drives are inputs, held against equations written down here, and against the same
mechanism along an angle.
"""

from __future__ import annotations

import numpy as np
import pytest

from planter.mechanism.model import Model
from planter.mechanism.state_space.model import DynamicsModel
from tests.support import own

G = 9.81
RANDOM = np.random.default_rng(7)
TRAIN = {"A_1_mm": 21, "A_2_mm": 21, "k_1": 0.14, "k_2": 0.14, "t_1_deg": 20}


def load_model(
    name: str, file: str = "", inputs: tuple[str, ...] = (), **values: float
) -> DynamicsModel:
    return DynamicsModel(own.dynamics(name, file, **values), inputs)


def compute_cart_rates(state: np.ndarray, force: float, pole: float) -> np.ndarray:
    """Return x' by Newton's laws of the cart and of the pole about its pin; `pole` [kg]."""
    _, a, speed, spin = state
    cart, damping, arm, inertia = 1.0, 0.1, 0.5, 0.025
    lever = pole * arm * np.cos(a)
    matrix = [[cart + pole, lever], [lever, inertia + pole * arm**2]]
    push = force - damping * speed + pole * arm * np.sin(a) * spin**2
    return np.array([speed, spin, *np.linalg.solve(matrix, [push, -pole * G * arm * np.sin(a)])])


def test_cart_pole_has_the_textbook_equations() -> None:
    model = load_model("cart_pole")
    assert [(x.name, x.low, x.high) for x in model.inputs] == [("F", -12, 12)]
    for _ in range(10):
        state, force = RANDOM.normal(size=4), RANDOM.uniform(-12, 12)
        rates = model.rates(0, state, np.array([force]))
        assert rates == pytest.approx(compute_cart_rates(state, force, 0.3), rel=1e-12, abs=1e-12)
        assert np.abs(rates - compute_cart_rates(state, force, 0.303)).max() > 1e-6


@pytest.mark.parametrize(("bend", "is_equal"), [(-50, True), (-49, False)])
def test_rotary_transplanter_equals_train_along_angle(bend: float, is_equal: bool) -> None:
    """At a constant speed the input balances the motor of `planetary_train` and the friction."""
    gear, arm, reach = 7850 * 0.01 * np.pi * 0.021**2, 0.5, 0.042
    body, disc = gear + arm, gear * 0.021**2 / 2
    centroid = arm * reach / body
    inertia = disc + gear * centroid**2 + 0.001 + arm * (reach - centroid) ** 2
    train = own.machine(
        "planetary_train",
        omega_rpm=100,
        rho_deg=0,
        m_m_kg=2 * gear,
        J_m_kg_m2=2 * disc,
        m_p_kg=body,
        s_mm=1e3 * centroid,
        J_p_kg_m2=inertia,
    )
    phases = np.radians(20)
    sun_turned = phases + 2 * np.arctan2(0.14 * np.sin(phases), 1 - 0.14 * np.cos(phases))
    model = load_model(
        "rotary_transplanter", **TRAIN, bend_deg=bend, t_2_deg=-50 - np.degrees(sun_turned)
    )
    angles, speed = np.linspace(0, 6, 25), 100 * np.pi / 30
    expected = Model(train)(angles)
    names = [output.name for output in model.outputs]
    torques, tips = [], []
    for angle in angles:
        idle, driven = (
            model.rates(0, np.array([angle, speed]), np.array([torque]))[1] for torque in (0.0, 1.0)
        )
        torques.append(-idle / (driven - idle))
        outputs = model.outputs_at(0, np.array([angle, speed]))
        tips.append(outputs[[names.index("x_tip"), names.index("y_tip")]])
    error = np.abs(np.array(torques) - 0.02 * speed - expected["M_in"]).max()
    gap = np.abs(np.transpose(tips) - [expected["x_tip"], expected["y_tip"]]).max()
    assert (max(error, gap) < 1e-10) == is_equal


def test_released_toggle_press_balances_its_motor() -> None:
    """Torque and load change the energy of ram and flywheel: M x'' by the slope of the ram."""
    model = load_model(
        "toggle_press", "released_toggle_press", ("T_Nm",), phi_0_deg=60, omega_start_rpm=120
    )
    names = [state.name for state in model.states]
    crank, ram = names.index("omega"), names.index("s_dot")
    count = len(names) // 2
    for torque in (-90.0, 0.0, 90.0):
        rates = model.rates(0, model.start, np.array([torque]))
        powers = {
            "motor": torque * model.start[crank],
            "load": (12 * G - 5000) * model.start[ram],
            "flywheel": 0.1 * model.start[crank] * rates[crank],
            "ram": 12 * model.start[ram] * rates[ram],
        }
        supplied, stored = powers["motor"] + powers["load"], powers["flywheel"] + powers["ram"]
        assert supplied == pytest.approx(stored, rel=1e-10)
        assert supplied != pytest.approx(stored + 0.001 * powers["flywheel"], rel=1e-10)
        assert rates[:count] == pytest.approx(model.start[count:], abs=1e-14)
        slopes = model.constraint_slopes(0, model.start, np.array([torque]))
        assert slopes[len(model.constraints) :] @ rates == pytest.approx(0, abs=1e-8)
