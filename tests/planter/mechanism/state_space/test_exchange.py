"""Units for model exchange: FMPy accepts them, and integrates what the model says."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from tempfile import mkdtemp

import numpy as np
import pytest

from tests.planter.mechanism.state_space.test_model import find_path, model
from tests.support.cli import answer, refusal
from tests.support.lanes import needs_compiler

fmpy = pytest.importorskip("fmpy", reason="FMPy is not installed")
validation = pytest.importorskip("fmpy.validation")
NAMES = "cart", "cranks", "rubbing", "row_unit"
pytestmark = needs_compiler


@cache
def unit(name: str) -> Path:
    file = Path(mkdtemp()) / f"{name}.fmu"
    result = answer("export", "fmu", str(find_path(name)), "--out", str(file))
    assert (result["fmi"], result["inputs"]) == ("2.0", len(model(name).inputs))
    return file


def open_instance(name: str) -> object:
    description = fmpy.read_model_description(str(unit(name)))
    folder = fmpy.extract(str(unit(name)), mkdtemp())
    instance = fmpy.instantiate_fmu(folder, description, "ModelExchange")
    instance.setupExperiment()
    instance.enterInitializationMode()
    instance.exitInitializationMode()
    return instance


@pytest.mark.parametrize("name", NAMES)
def test_fmpy_accepts_the_unit(name: str) -> None:
    assert validation.validate_fmu(str(unit(name))) == []


@pytest.mark.parametrize("name", ["cart", "cranks", "row_unit"])
def test_motion_by_another_integrator_is_ours(name: str) -> None:
    """Cart and pendulum from the side; cranks before their flat pose; a wheel that strikes soil."""
    subject, end = model(name), 0.4
    names = [state.name for state in subject.states]
    start = dict(zip(names, subject.start.tolist(), strict=True))
    if name == "cart":
        start["a"] = 0.8
    result = fmpy.simulate_fmu(
        str(unit(name)),
        fmi_type="ModelExchange",
        stop_time=end,
        output_interval=end / 20,
        relative_tolerance=1e-9,
        start_values=start,
        output=names,
    )
    times = np.linspace(0, end, 21)
    motion = subject.dynamics.run(times, state=np.array(list(start.values())))
    for index, key in enumerate(names):
        moved = np.interp(times, result["time"], result[key])
        np.testing.assert_allclose(moved, motion.states[index], atol=1e-6)
    assert np.ptp(motion.states, axis=1).max() > 0.1


@pytest.mark.parametrize("name", NAMES)
def test_directional_derivatives_are_those_of_the_model(name: str) -> None:
    subject, instance = model(name), open_instance(name)
    n, m, q, r = (
        len(part) for part in (subject.states, subject.inputs, subject.parameters, subject.outputs)
    )
    unknown = [*range(n, 2 * n), *range(2 * n + m + q, 2 * n + m + q + r)]
    settable = [*range(n), *range(2 * n, 2 * n + m + q)]
    columns = [instance.getDirectionalDerivative(unknown, [place], [1.0]) for place in settable]
    rows = (
        np.hstack(subject.linearised(0.0, subject.start)),
        np.hstack(subject.linearised_outputs(0.0, subject.start)),
    )
    expected = np.vstack(rows)
    np.testing.assert_allclose(np.array(columns).T, expected, atol=1e-12 * np.abs(expected).max())


def test_bad_calls_are_refused_and_states_are_restored() -> None:
    instance = open_instance("cart")
    with pytest.raises(fmpy.fmi1.FMICallException):
        instance.setReal([5], [1.0])
    with pytest.raises(fmpy.fmi1.FMICallException):
        instance.getReal([999])
    with pytest.raises(fmpy.fmi1.FMICallException):
        instance.setReal([0], [float("nan")])
    with pytest.raises(fmpy.fmi1.FMICallException):
        instance.getDirectionalDerivative([0], [0], [1.0])
    saved = instance.getFMUstate()
    instance.setReal([0, 8], [0.25, 7.0])
    assert instance.getReal([0, 8]) == [0.25, 7.0]
    instance.setFMUstate(saved)
    assert instance.getReal([0, 8]) == [0.0, 0.0]
    instance.setReal([0], [0.5])
    instance.setFMUstate(instance.deSerializeFMUstate(instance.serializeFMUstate(saved)))
    assert instance.getReal([0]) == [0.0]


def test_options_without_effect_are_refused(tmp_path: Path) -> None:
    out = "--out", str(tmp_path / "unit.fmu")
    assert "--fmi" in refusal("export", "fmu", str(find_path("cart")), "--fmi", "3.0", *out)
    assert "--stabilise" in refusal("export", "fmu", "wang2017", "--stabilise", "10", *out)
