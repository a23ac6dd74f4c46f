"""Stress of teeth: Hertz's line contact beside his elliptic one and ISO 6336, Lewis's teeth beside
a textbook's.
"""

import math

import numpy as np
import pytest
from scipy.special import ellipe, ellipk

from planter.kernels.formulas import load

STRENGTH = load("gear_strength")
ANGLE = math.radians(20)
STEEL = [206e9, 0.3]
WIDTH = 0.012


def contact(
    force: float, kappa1: float, kappa2: float, material: list[float] = STEEL
) -> dict[str, float]:
    load = [force, WIDTH, ANGLE]
    return STRENGTH.at("contact_stress", kappa1=kappa1, kappa2=kappa2, load=load, material=material)


def test_steel_elasticity_factor_matches_iso_6336() -> None:
    """ISO 6336-2: 189.8 sqrt(N/mm2) for E = 206 000 N/mm2 and 0.3, stress over the root of load
    times curvature.
    """
    stress = contact(900.0, 1 / 0.02, 1 / 0.04)
    factor = stress["p0"] / math.sqrt(900.0 / WIDTH * stress["kappa"])
    assert factor / 1e3 == pytest.approx(189.8, abs=0.05)
    bronze = contact(900.0, 1 / 0.02, 1 / 0.04, [103e9, 0.3])
    assert bronze["p0"] == pytest.approx(stress["p0"] / math.sqrt(2), rel=1e-12)


@pytest.mark.parametrize(("slenderness", "tolerance"), [(30.0, 0.01), (1000.0, 2e-5)])
def test_a_long_ellipse_of_contact_becomes_the_strip(slenderness: float, tolerance: float) -> None:
    """Johnson, Contact Mechanics (1985), (4.26): curvatures A, B of an elliptic contact with
    semi-axes a, b.
    """
    pressures = contact(900.0, 1 / 0.02, 1 / 0.04)
    b, modulus = pressures["half_width"], STEEL[0] / (2 * (1 - STEEL[1] ** 2))
    m = 1 - 1 / slenderness**2
    across = (
        pressures["p0"]
        / modulus
        * b
        / (m * (slenderness * b) ** 2)
        * (slenderness**2 * ellipe(m) - ellipk(m))
    )
    assert 2 * across == pytest.approx(pressures["kappa"], rel=tolerance)
    assert 2 * across != pytest.approx(pressures["kappa"], rel=tolerance / 100)


def test_concave_flanks_reduce_contact_pressure() -> None:
    stress = contact(900.0, 50.0, 25.0)
    assert math.pi * stress["half_width"] * stress["p0"] / 2 * WIDTH == pytest.approx(
        900.0, rel=1e-12
    )
    assert stress["kappa"] == pytest.approx((50.0 + 25.0) / math.sin(ANGLE), rel=1e-12)
    assert contact(900.0, 50.0, -25.0)["p0"] < contact(900.0, 50.0, 0.0)["p0"] < stress["p0"]
    assert contact(-5.0, 50.0, 25.0)["p0"] == 0


TABLE = {
    12: 0.245,
    14: 0.277,
    16: 0.296,
    18: 0.309,
    20: 0.322,
    24: 0.337,
    30: 0.359,
    43: 0.397,
    75: 0.435,
    150: 0.460,
    300: 0.472,
}
"""Lewis form factors of 20 deg full-depth teeth as a textbook tabulates them (Shigley and Mischke,
table 14-2).
"""


def test_form_factor_is_within_ten_percent_of_table() -> None:
    module = 2e-3
    for teeth, tabulated in TABLE.items():
        stress = STRENGTH.at(
            "bending_stress", kappa1=2 / (teeth * module), module=module, load=[1.0, 0.01, ANGLE]
        )
        assert stress["Y"] == pytest.approx(tabulated, rel=0.1)
        assert 1 / stress["teeth_inverse"] == pytest.approx(teeth)
    rack = STRENGTH.at("bending_stress", kappa1=0.0, module=module, load=[1.0, 0.01, ANGLE])
    assert rack["Y"] == pytest.approx(0.485, rel=0.01)


def test_the_textbook_s_pinion_of_16_teeth() -> None:
    """Shigley and Mischke, example 14-1: 8 teeth an inch, face 1.5 inch, 10 kpsi; 365 lbf at a
    factor of 1.52.
    """
    inch, pound = 0.0254, 4.4482216
    module, width, force = inch / 8, 1.5 * inch, 365 * 1.52 * pound
    load = [force / math.cos(ANGLE), width, ANGLE]
    stress = STRENGTH.at("bending_stress", kappa1=2 / (16 * module), module=module, load=load)
    assert stress["sigma"] == pytest.approx(10e3 * pound / inch**2, rel=0.04)


def test_the_pressure_angle_turns_with_the_pitch_curve_s_tangent() -> None:
    """On a circle about a point off its middle, whose tangent is known without any slope."""
    radius, offset = 0.03, 0.006
    for turned in np.linspace(0.1, 6.2, 9):
        point = np.array([offset + radius * math.cos(turned), radius * math.sin(turned)])
        r, tangent = math.hypot(*point), np.array([-math.sin(turned), math.cos(turned)])
        across = np.array([-point[1], point[0]]) / r
        off = math.acos(float(np.clip(tangent @ across, -1, 1))) * math.copysign(1, tangent @ point)
        slope = r * math.tan(off)
        stress = STRENGTH.at("pressure_angles", r=r, dr=slope, alpha0=ANGLE)
        assert stress["towards"] == pytest.approx(ANGLE + off, abs=1e-7)
        assert stress["towards"] + stress["against"] == pytest.approx(2 * ANGLE)
