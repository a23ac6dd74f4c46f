"""Units by the ending of a key."""

from __future__ import annotations

import math

import pytest

from planter.errors import InputError
from planter.files.units import display_key, display_unit, parse_unit, unit_factor


@pytest.mark.parametrize(
    ("key", "unit_text", "si"),
    [
        ("design.R3_mm", "mm", 1e-3),
        ("nozzle.hinge_A_mm[2]", "mm", 1e-3),
        ("rise_delta_deg[0]", "deg", math.pi / 180),
        ("speed_rpm", "r/min", 2 * math.pi / 60),
        ("J56_about_A1_kg_m2", "kg m2", 1),
        ("C1_centroidal_xx_yy_zz_kg_m2[1]", "kg m2", 1),
        ("tip_speed_mm_s", "mm/s", 1e-3),
        ("rate_N_m", "N/m", 1),
        ("M_Q_Nm", "N m", 1),
        ("variance_N2", "N2", 1),
        ("top_q0_dot_per_s", "1/s", 1),
        ("c_Ns_m", "N s/m", 1),
        ("m31", "", 1),
        ("bits_per_variable", "", 1),
    ],
)
def test_unit_is_the_longest_known_ending(key: str, unit_text: str, si: float) -> None:
    assert display_unit(key) == unit_text
    assert unit_factor(key) == pytest.approx(si, rel=1e-15)


@pytest.mark.parametrize("key", ["mm", "kg", "deg", "farmm", "R3_MM", "R3_mm_old"])
def test_a_unit_counts_only_as_an_ending_after_an_underscore(key: str) -> None:
    assert display_unit(key) == ""
    assert unit_factor(key) == 1


def test_units_without_a_key_are_refused_by_name() -> None:
    assert display_unit(display_key("top_q0_dot", "1/s")) == "1/s"
    with pytest.raises(InputError, match=r"flux.*W/m3"):
        display_key("flux", "W/m3")


@pytest.mark.parametrize(
    ("text", "si"),
    [
        ("", 1),
        ("1", 1),
        ("%", 0.01),
        ("mm", 1e-3),
        ("cm2", 1e-4),
        ("kN", 1e3),
        ("N mm", 1e-3),
        ("kg m2", 1),
        ("g", 1e-3),
        ("MPa", 1e6),
        ("µm", 1e-6),
        ("deg/s", math.pi / 180),
        ("r/min", math.pi / 30),
        ("rpm", math.pi / 30),
        ("m/s2", 1),
        ("kJ", 1e3),
        ("N*m/rad", 1),
        ("1/s", 1),
        ("m s^-2", 1),
        ("km/h", 1 / 3.6),
        ("°", math.pi / 180),
    ],
)
def test_units_in_si(text: str, si: float) -> None:
    assert parse_unit(text).factor == pytest.approx(si, rel=1e-15)


@pytest.mark.parametrize(
    ("first", "other", "same"),
    [
        ("N m", "J", True),
        ("kN", "kg m/s2", True),
        ("MPa", "N/mm2", True),
        ("W", "N m/s", True),
        ("rpm", "deg/s", True),
        ("N", "N m", False),
        ("deg", "1", False),
        ("1/s", "rad/s", False),
        ("mm", "kg", False),
        ("%", "", True),
    ],
)
def test_kinds_are_distinguished(first: str, other: str, same: bool) -> None:
    assert parse_unit(first).same_kind(parse_unit(other)) is same


def test_a_square_is_in_the_square_of_the_unit() -> None:
    assert parse_unit("kN").squared().factor == 1e6
    assert parse_unit("kN").squared().same_kind(parse_unit("N2"))


@pytest.mark.parametrize("text", ["furlong", "kmin", "N+m", "Nm", "mmm"])
def test_invalid_unit_is_named(text: str) -> None:
    with pytest.raises(ValueError, match="is not a unit"):
        parse_unit(text)
