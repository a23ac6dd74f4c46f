"""Units as papers print them: factors from the definitions of the SI, kinds told apart."""

import math

import pytest

from planter.files.units import parse_unit


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
