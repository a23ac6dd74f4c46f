"""Envelopes of a rack as derived: contact conditions, rates against differences, limits that are
known.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from derive.mechanics.gearing import rack
from planter.kernels import Array
from planter.kernels.formulas import load

RACK = load("rack_teeth")
ALPHA = math.radians(20)
FORMS = {
    "flank": {"xi": 0.004, "side": 1.0, "alpha": ALPHA},
    "fillet": {"middle": 0.005, "depth": 0.0018, "rho": 0.0007},
    "equidistant": {"height": 0.002},
}


def place(s: float) -> list[float]:
    """Of a logarithmic spiral-like curve whose curvature falls evenly: by its own integral, in
    closed steps.
    """
    kappa, fall = 40.0, 900.0
    fine = np.linspace(0.0, s, 4001)
    heading = kappa * fine - fall * fine**2 / 2
    x, y = (np.trapezoid(f(heading), fine) for f in (np.cos, np.sin))
    return [x, y, math.cos(heading[-1]), math.sin(heading[-1]), kappa - fall * s]


def cut(form: str, s: float) -> dict[str, float]:
    arc = {} if form == "equidistant" else {"s": s}
    return RACK.at(form, place=place(s), **arc, **FORMS[form])


@pytest.mark.parametrize("form", FORMS)
def test_tangent_and_rates_are_those_of_the_points(form: str) -> None:
    s, h = 0.0031, 2e-6
    before, point, after = (cut(form, at) for at in (s - h, s, s + h))
    moved = np.array([after[k] - before[k] for k in ("px", "py")]) / (2 * h)
    tangent = np.array([point["ex"], point["ey"]])
    np.testing.assert_allclose(moved, point["rate"] * tangent, atol=2e-5)
    turned = np.array([after[k] - before[k] for k in ("ex", "ey")]) / (2 * h)
    assert tangent @ tangent == pytest.approx(1, abs=1e-14)
    assert tangent[0] * turned[1] - tangent[1] * turned[0] == pytest.approx(
        point["turning"], rel=1e-5
    )


@pytest.mark.parametrize("form", FORMS)
def test_the_normal_passes_through_the_pitch_point(form: str) -> None:
    x, y, *_ = place(0.0031)
    point = cut(form, 0.0031)
    assert (point["px"] - x) * point["ex"] + (point["py"] - y) * point["ey"] == pytest.approx(
        0, abs=1e-17
    )


def test_flank_joins_the_fillet() -> None:
    """At the end of the straight flank both have the same point and tangent, whatever the curve."""
    sizes = RACK.at("sizes", rack=[2e-3, 1.0, 0.25, 0.1, ALPHA, 1e-5, 1.0])
    assert sizes["straight"] == pytest.approx(2e-3 * 0.9, rel=1e-13)
    assert sizes["round_"] == pytest.approx(2e-3 * 0.25 / (1 - math.sin(ALPHA)), rel=1e-13)
    xi = sizes["half"]
    s = xi + RACK.at("reach", kappa=0.0, height=sizes["straight"], alpha=ALPHA)["reach"]
    flank = RACK.at("flank", place=place(s), s=s, xi=xi, side=1.0, alpha=ALPHA)
    fillet = RACK.at(
        "fillet",
        place=place(s),
        s=s,
        middle=sizes["beside"],
        depth=sizes["sunk"],
        rho=sizes["round_"],
    )
    for key in ("px", "py", "ex", "ey"):
        assert fillet[key] == pytest.approx(flank[key], abs=1e-15)


def test_flank_regularity_is_the_relative_rate() -> None:
    bends, s, h = np.array([40.0, -900.0, 5e4]), 0.0031, 1e-7

    def at(aside: float) -> Array:
        kappa = bends[0] + bends[1] * aside + bends[2] * aside**2 / 2
        local_bends = [kappa, bends[1] + bends[2] * aside, bends[2]]
        result = RACK.at(
            "regularity", bends=local_bends, s=s + aside, xi=0.004, side=1.0, alpha=ALPHA
        )
        return np.array(list(result.values()))

    np.testing.assert_allclose((at(h) - at(-h))[:2] / (2 * h), at(0.0)[1:], rtol=1e-6)
    rate = RACK.at("flank", place=[0, 0, 1, 0, 40.0], s=s, xi=0.004, side=1.0, alpha=ALPHA)["rate"]
    assert at(0.0)[0] == pytest.approx(rate / math.sin(ALPHA), rel=1e-13)


def test_full_tip_radius_is_the_largest_possible() -> None:
    wide = RACK.at("sizes", rack=[2e-3, 1.0, 0.25, 0.0, math.radians(26), 0.0, 1.0])
    assert wide["beside"] == pytest.approx(wide["pitch_"] / 2, rel=1e-13)
    sharp = RACK.at("sizes", rack=[2e-3, 1.0, 0.25, 0.0, ALPHA, 0.0, 0.1])
    assert sharp["round_"] == pytest.approx(2e-4)
    assert sharp["straight"] > 2e-3


def test_the_mate_of_a_circle_is_a_circle() -> None:
    mate = RACK.at("mate", contact=[0.03, 0, 0, 0.6, 0, 1.0], a=0.08)
    assert list(mate.values()) == pytest.approx([1.0, 0.05, 0.0, 0.0], abs=1e-16)
    assert RACK.at("rolling", r=0.03, dr=0.002, a=0.08)["dratio"] == pytest.approx(
        0.002 * 0.08 / 0.05**2
    )


def test_every_form_is_emitted() -> None:
    assert {form.name for form in rack.build_rack_system().closed_forms} == RACK.sidecar[
        "functions"
    ].keys()
