"""`planter export motion`: the numbers of `simulate` over time."""

from pathlib import Path

import jsonschema
import numpy as np
import pytest

from planter.exports.quantities import build_motion
from planter.interchange.motion_tables import FORMATS
from planter.optimise.sampled_cycle import sample_angles
from planter.planting.file import load
from planter.planting.functions import MODELS, Model
from planter.planting.model import Device, build_machine
from planter.report.files import read_cycle_csv
from tests.support.cli import answer, refusal
from tests.support.schemas import load_schema


@pytest.mark.parametrize("model", MODELS)
def test_a_turn_has_the_bits_of_simulate(model: Model, tmp_path: Path) -> None:
    device = Device(load("compact"), model)
    samples = device.machine.objective.samples
    result = answer("export", "motion", "compact", "--model", model, "--out", str(tmp_path))
    jsonschema.validate(result, load_schema("export motion"))
    _, columns = read_cycle_csv(tmp_path / "motion.csv")
    expected = device.columns(device.design, sample_angles(samples, 2 * np.pi))
    assert list(columns) == ["time_s", *expected]
    np.testing.assert_allclose(columns["phi_deg"][:-1], expected.pop("phi_deg"), rtol=1e-15)
    for key, values in expected.items():
        assert columns[key][:-1].tolist() == values.tolist()
    assert (result["columns"], result["rows"]) == (len(columns), samples + 1)
    assert columns["time_s"][-1] == pytest.approx(
        60 / device.machine.operation.speed_rpm, rel=1e-14
    )


def test_cycles_are_consecutive() -> None:
    """Forces repeat, angles go on; time is angle over speed, and another speed is another time."""
    motion = build_motion(
        build_machine(Device(load("wang2017", {"operation.speed_rpm": 30.0}))), turns=3, samples=24
    )
    columns = {column.name: column.values for column in motion.columns}
    assert len(motion.time) == 73
    assert motion.time[-1] == pytest.approx(6.0, rel=1e-14)
    np.testing.assert_allclose(columns["phi"], motion.time * np.pi, rtol=1e-14)
    np.testing.assert_allclose(columns["F_support"][:25], columns["F_support"][48:], rtol=1e-9)
    np.testing.assert_allclose(
        columns["phi72"][48:] - columns["phi72"][:25], -4 * np.pi, rtol=1e-12
    )
    assert np.abs(np.diff(columns["F_support"])).max() > 0.01


@pytest.mark.parametrize("form", FORMATS)
def test_every_format_is_written(form: str, tmp_path: Path) -> None:
    result = answer(
        "export", "motion", "wang2017", "--format", form, "--samples", "8", "--out", str(tmp_path)
    )
    assert result["format"] == form
    assert {Path(file).name for file in result["files"]} == {
        path.name for path in tmp_path.iterdir() if path.name[0] != "."
    }


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--turns", "0"), "between 1 and 555 with 360 samples"),
        (("--turns", "99999"), "--turns = 99999"),
        (("--samples", "4"), "between 8 and"),
    ],
)
def test_invalid_request_is_refused(
    arguments: tuple[str, ...], message: str, tmp_path: Path
) -> None:
    assert message in refusal("export", "motion", "wang2017", *arguments, "--out", str(tmp_path))
