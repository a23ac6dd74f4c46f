"""Measures of a turn and of a motion against closed forms and an integrator; what a quantity can
depend on.
"""

import math

import numpy as np
import pytest

from planter.engine.measures import parse_measure
from planter.errors import InputError
from planter.mechanism import printed
from tests.support import own

LIFT = 0.014
"""Of the cam: s = h (1 - cos phi) / 2, y = h/2 (1 - cos) has these means."""


def evaluate_measure(text: str, samples: int | None = None) -> float:
    return printed.evaluate_measure(
        own.file("cam_follower"), parse_measure(text, "test"), samples, None
    )


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("max s", LIFT),
        ("min s", 0),
        ("range s", LIFT),
        ("mean s", LIFT / 2),
        ("rms s", LIFT * math.sqrt(3 / 8)),
        ("variance s", LIFT**2 / 8),
        ("s at 60", LIFT / 4),
        ("s at -300 deg", LIFT / 4),
        ("max abs s_dot", LIFT / 2 * 8 * math.pi),
        ("min s_ddot", -LIFT / 2 * (8 * math.pi) ** 2),
    ],
)
def test_a_turn_is_measured_to_rounding(text: str, value: float) -> None:
    assert evaluate_measure(text) == pytest.approx(value, rel=1e-9, abs=1e-12)


def test_of_few_samples_the_extreme_is_theirs() -> None:
    assert evaluate_measure("max s", samples=7) == pytest.approx(
        LIFT / 2 * (1 - math.cos(6 * math.pi / 7)), rel=1e-12
    )
    assert evaluate_measure("max s", samples=7) != pytest.approx(LIFT, rel=1e-3)


def test_quantities_depend_only_on_their_inputs() -> None:
    cam, crank = own.file("cam_follower"), own.file("slider_crank")
    assert printed.find_dependencies(cam, "s") == {"h_mm"}
    assert {"mu", "m_s_kg", "k_N_m", "omega_rpm"} <= printed.find_dependencies(cam, "N_cam")
    assert printed.find_dependencies(crank, "s") == {"r_mm", "l_mm", "e_mm"}
    assert "mu" in printed.find_dependencies(crank, "F_Ax")


def test_motion_is_measured_at_a_time_and_over_a_span() -> None:
    file = own.file("manipulator")
    run = own.dynamics("manipulator").run(np.linspace(0, 0.4, 4001), 1e-11)
    x = run.results["x_G"]
    assert printed.evaluate_measure(
        file, parse_measure("x_G at 0.4 s", "test"), None, None
    ) == pytest.approx(x[-1], rel=1e-8)
    for text, value in (
        ("min x_G", x.min()),
        ("mean x_G", x.mean()),
        ("rms x_G", np.sqrt((x**2).mean())),
    ):
        assert printed.evaluate_measure(
            file, parse_measure(text, "test"), None, 0.4
        ) == pytest.approx(value, rel=1e-4)


@pytest.mark.parametrize(
    ("name", "text", "until"),
    [
        ("cam_follower", "s at 1 s", None),
        ("cam_follower", "max s", 2.0),
        ("manipulator", "max x_G", None),
        ("manipulator", "x_G at 90", None),
        ("manipulator", "x_G at 90 deg", None),
    ],
)
def test_a_turn_has_angles_and_a_motion_times(name: str, text: str, until: float | None) -> None:
    with pytest.raises(InputError, match=r"drives cam_follower|moves freely"):
        printed.evaluate_measure(own.file(name), parse_measure(text, "test"), None, until)


@pytest.mark.parametrize("text", ["s", "2 max s", "most s", "max s at 3", "max s + min s"])
def test_ambiguous_measure_is_refused(text: str) -> None:
    with pytest.raises(InputError, match=r"n\.quantity = .*: .*it must be MEASURE"):
        parse_measure(text, "n.quantity =")
