"""The reader of machine data: SI numbers by the endings of keys, to the working precision."""

from decimal import Decimal
from pathlib import Path

import mpmath
import pytest
from mpmath import mpf

from derive.evaluate import MachineFile

FILE = """
[carrier]
speed_rpm = 30
speed_deg_per_s = 180
radius_mm = 0.1
reach_mm = [1, 2.5]
gravity_m_s2 = 9.81
modulus_GPa = 210
travel_mm_s = 40
ratio = 0.1
family = "ellipse"

[[pose]]
x_mm = 7
phi_deg = 90
"""


@pytest.fixture
def machine(tmp_path: Path) -> MachineFile:
    (tmp_path / "machine.toml").write_text(FILE)
    return MachineFile.read(tmp_path / "machine.toml")


def test_numbers_are_in_si_to_the_working_precision(machine: MachineFile) -> None:
    with mpmath.workdps(40):
        expected = {
            "carrier.speed_rpm": mpmath.pi,
            "carrier.speed_deg_per_s": mpmath.pi,
            "carrier.radius_mm": mpf("1e-4"),
            "carrier.reach_mm[1]": mpf("2.5e-3"),
            "carrier.gravity_m_s2": mpf("9.81"),
            "carrier.travel_mm_s": mpf("0.04"),
            "carrier.modulus_GPa": mpf("2.1e11"),
            "carrier.ratio": mpf("0.1"),
            "pose[0].phi_deg": mpmath.pi / 2,
        }
        for place, value in expected.items():
            assert abs(machine.si(place) - value) <= mpf(10) ** -38 * value, place
        assert abs(machine.si("carrier.ratio") - mpf(0.1)) > mpf(10) ** -20
        assert machine.all_si("carrier.reach_mm") == [mpf("1e-3"), mpf("2.5e-3")]


def test_non_numbers_stay_in_their_table(machine: MachineFile) -> None:
    assert machine.tables["carrier"]["family"] == "ellipse"
    assert machine.tables["carrier"]["ratio"] == Decimal("0.1")


def test_a_missing_key_is_an_error(machine: MachineFile) -> None:
    with pytest.raises(KeyError, match="speed_deg"):
        machine.si("carrier.speed_deg")
