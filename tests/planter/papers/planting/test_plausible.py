"""Warnings of values that are unlike any machine's: each mistake of a unit, and none for the
built-in machines.
"""

import pytest

from planter.files import examples, units
from planter.papers.planting.file import load
from planter.papers.planting.plausible import RANGES, find_implausible_values
from tests.support.cli import answer


@pytest.mark.parametrize("name", examples.list_examples("planting"))
def test_built_in_machines_are_usual(name: str) -> None:
    assert find_implausible_values(load(name)) == []
    assert answer("validate", name)["warnings"] == []


@pytest.mark.parametrize(
    ("name", "value", "usual"),
    [
        ("nozzle.tip_distance_mm", 0.21, "0.21 mm is not what is usual, 50 to 600 mm"),
        (
            "inertia.J7_about_B1_kg_m2",
            1500.0,
            "1500 kg m2 is not what is usual, 1e-05 to 0.2 kg m2",
        ),
        ("operation.speed_rpm", 100_000.0, "100000 r/min is not what is usual, 2 to 300 r/min"),
        ("operation.forward_speed_m_s", -20.0, "-20 m/s is not what is usual, up to 3 m/s"),
        ("nozzle.hinge_A_mm[2]", 4000.0, "nozzle.hinge_A_mm[2] = 4000 mm"),
    ],
)
def test_validate_and_simulate_warn_of_a_wrong_unit(name: str, value: float, usual: str) -> None:
    setting = f"{name}={value!r}"
    result = answer("validate", "wang2017", "--set", setting)
    assert result["valid"] is True
    (warning,) = (w for w in result["warnings"] if w["name"] == "implausible_value")
    assert warning.keys() == {"name", "message"}
    assert warning["name"] == "implausible_value"
    assert usual in warning["message"]
    assert warning in answer("simulate", "wang2017", "--set", setting)["warnings"]


def test_ranges_are_of_numbers_with_units_and_name_their_reason() -> None:
    numbers = load("wang2017").numbers()
    for item in RANGES:
        assert any(path == item.path or path.startswith(f"{item.path}[") for path in numbers), (
            item.path
        )
        assert units.display_unit(item.path)
        assert 0 <= item.low < item.high
        assert item.reason
    assert len({item.path for item in RANGES}) == len(RANGES)
