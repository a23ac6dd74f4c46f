"""Units for co-simulation and tables over time of mechanisms of one's own have the model's
numbers.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import jsonschema
import numpy as np
import pytest

from planter.engine.machine import load_machine
from planter.exports import co_simulation, fmu
from planter.exports.quantities import build_motion
from planter.mechanism import file
from planter.mechanism.model import Model
from tests.planter.exports.exported import machine_file
from tests.support import own
from tests.support.cli import answer, refusal
from tests.support.lanes import needs_compiler
from tests.support.schemas import load_schema

SLIDER = "slider_crank"


@pytest.fixture(autouse=True)
def _quick() -> Iterator[None]:
    """Only the library of this system, compiled without passes."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            co_simulation,
            "PLATFORMS",
            {k: v for k, v in co_simulation.PLATFORMS.items() if k == "linux64"},
        )
        patch.setattr(co_simulation, "FLAGS", ("-O0", *co_simulation.FLAGS[1:]))
        yield


@needs_compiler
@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_a_unit_has_the_numbers_of_the_model(version: str, tmp_path: Path) -> None:
    fmpy = pytest.importorskip("fmpy")
    validation = pytest.importorskip("fmpy.validation")
    path, unit = machine_file(SLIDER), tmp_path / "slider.fmu"
    record = answer(*f"export fmu {path} --fmi {version} --out {unit}".split())
    jsonschema.validate(record, load_schema("export fmu"))
    assert validation.validate_fmu(str(unit)) == []
    changed = {"machine.m_r": 1.1, "design.r": 0.06, "speed": 20.0, "phi_start": 0.4}
    names = ["phi", "s", "F_Ox", "M_in", "N_guide"]
    result = fmpy.simulate_fmu(
        str(unit), output=names, start_values=changed, stop_time=0.5, output_interval=0.0125
    )
    machine = file.load(path, {"m_r_kg": 1.1, "r_mm": 60.0, "omega_rpm": 600 / np.pi})
    expected = own.evaluate_lane(machine, result["phi"])
    np.testing.assert_allclose(result["phi"], 0.4 + 20.0 * result["time"], rtol=1e-12)
    for name in names[1:]:
        assert np.abs(result[name] - expected[name]).max() <= 1e-10 * np.abs(expected[name]).max()
    if version == "2.0":
        with pytest.raises(Exception, match="fmi2"):
            fmpy.simulate_fmu(
                str(unit), output=names, start_values={"design.l": 0.04}, stop_time=0.1
            )


def test_variables_are_the_values_of_the_file() -> None:
    owner = load_machine(str(machine_file(SLIDER)))
    variables = {variable.name: variable for variable in fmu.build_model(owner).variables}
    radius, mass = variables["design.r"], variables["machine.m_r"]
    assert (radius.low, radius.high, radius.display_unit) == (
        pytest.approx(0.03),
        pytest.approx(0.08),
        "mm",
    )
    assert (mass.start, mass.low, mass.high, mass.unit) == (0.93, 0.0, None, "kg")
    assert sum(variable.causality == "input" for variable in variables.values()) == 1
    assert not [name for name in variables if name.startswith(("law_", "pivot_", "states_"))]


def test_motion_has_quantities_and_places_of_points(tmp_path: Path) -> None:
    path = machine_file(SLIDER)
    record = answer(*f"export motion {path} --samples 24 --turns 2 --out {tmp_path}".split())
    jsonschema.validate(record, load_schema("export motion"))
    owner = load_machine(str(path))
    model = Model(owner)
    columns = {column.name: column for column in build_motion(owner, 2, 24).columns}
    phi = columns["phi"].values
    assert record["rows"] == len(phi) == 49
    assert record["columns"] == len(columns)
    expected, places = model(phi), model.places(phi)
    for name in ("beta", "F_Ox", "M_in"):
        np.testing.assert_allclose(columns[name].values, expected[name], rtol=1e-12, atol=1e-12)
    assert set(places) <= set(columns)
    distance = np.hypot(
        places["x_rod__A"] - places["x_rod__slot"], places["y_rod__A"] - places["y_rod__slot"]
    )
    np.testing.assert_allclose(distance, owner.data[owner.find_index("l_mm")], rtol=1e-12)
    np.testing.assert_allclose(columns["x_rod__slot"].values, expected["s"], atol=1e-14)


def test_backward_drive_motion_runs_forward_in_time(tmp_path: Path) -> None:
    owner = load_machine(str(machine_file("cam_follower")), {"omega_rpm": -60.0})
    columns = {column.name: column.values for column in build_motion(owner, 1, 8).columns}
    assert columns["time"][-1] == pytest.approx(1.0)
    assert columns["phi"][-1] == pytest.approx(-2 * np.pi)
    message = refusal(
        *f"export motion {machine_file('cam_follower')} --set omega_rpm=0 --out {tmp_path}".split()
    )
    assert "values.omega_rpm = 0" in message
