"""Units of SI by their base units."""

import numpy as np
import pytest

from planter.exports.co_simulation import decompose_unit


@pytest.mark.parametrize(
    ("unit", "expected"),
    [
        ("1", {}),
        ("rad", {"rad": 1}),
        ("m/s2", {"m": 1, "s": -2}),
        ("kg m2", {"kg": 1, "m": 2}),
        ("N/m", {"kg": 1, "s": -2}),
        ("N m/rad", {"kg": 1, "m": 2, "s": -2, "rad": -1}),
        ("s/m", {"s": 1, "m": -1}),
    ],
)
def test_decompose_unit(unit: str, expected: dict[str, int]) -> None:
    assert decompose_unit(unit) == expected


def test_powers_add_up_in_products() -> None:
    """A watt is a newton metre per second, a joule a watt second."""
    for first, other in (("W", "N m/s"), ("J", "W s"), ("N", "J/m")):
        assert decompose_unit(first) == decompose_unit(other)
    assert decompose_unit("W") != decompose_unit("J")
    assert np.sum(list(decompose_unit("N").values())) == 0


@pytest.mark.parametrize("unit", ["mm", "furlong"])
def test_invalid_si_units_are_refused(unit: str) -> None:
    with pytest.raises(ValueError, match="is not a unit"):
        decompose_unit(unit)
