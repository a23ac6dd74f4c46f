"""Units (FMI) of driven machines and of free motion: FMPy accepts them and finds the model's
numbers.
"""

from __future__ import annotations

import ctypes
import subprocess
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

import jsonschema
import numpy as np
import pytest

from planter.engine.machine import load_machine
from planter.exports import fmu
from planter.exports.fmi import decompose_unit
from planter.kernels import Array
from planter.mechanism import file
from planter.mechanism.dynamics import Dynamics
from planter.mechanism.input_history import read_history
from tests.planter.exports.exported import machine_file
from tests.planter.mechanism.state_space.test_model import find_path, model
from tests.support import own
from tests.support.cli import answer
from tests.support.lanes import STRICT, needs_compiler, path_of
from tests.support.schemas import load_schema
from tests.support.units import quick_libraries

fmpy = pytest.importorskip("fmpy", reason="FMPy is not installed")
validation = pytest.importorskip("fmpy.validation")
SLIDER = "slider_crank"
FREE = "cart", "cranks", "rubbing", "row_unit", "odd"
WARNING, DISCARD = 1, 2
VERSIONS = "2.0", "3.0"
Refused = fmpy.fmi1.FMICallException
both_versions = pytest.mark.parametrize("version", VERSIONS)


@cache
def unit(name: str, version: str) -> Path:
    path = machine_file(name) if name == SLIDER else find_path(name)
    out = Path(mkdtemp()) / f"{name}.fmu"
    with quick_libraries():
        record = answer("export", "fmu", str(path), "--fmi", version, "--out", str(out))
    jsonschema.validate(record, load_schema("export fmu"))
    assert (record["fmi"], record["platforms"]) == (version, ["linux64"])
    return out


@cache
def unpack(name: str, version: str) -> Path:
    return Path(fmpy.extract(str(unit(name, version)), mkdtemp()))


class Instance:
    """A unit that FMPy has initialised, for one of its uses."""

    def __init__(self, name: str, version: str, use: str = "CoSimulation", **start: float) -> None:
        self.description = fmpy.read_model_description(str(unit(name, version)))
        variables = self.description.modelVariables
        self.references = {variable.name: variable.valueReference for variable in variables}
        self.messages: list[tuple[int, str]] = []
        self.raw: Any = fmpy.instantiate_fmu(
            str(unpack(name, version)), self.description, use, logger=self._remember
        )
        self.is_first = version == "2.0"
        self.set(**start)
        if self.is_first:
            self.raw.setupExperiment(startTime=0.0)
        self.raw.enterInitializationMode()
        self.raw.exitInitializationMode()

    def set(self, **values: float) -> None:
        write = self.raw.setReal if self.is_first else self.raw.setFloat64
        names = [name.replace("__", ".") for name in values]
        write([self.references[name] for name in names], list(values.values()))

    def _remember(self, *words: Any) -> None:
        """Status and text end what both versions tell."""
        self.messages.append((words[-3], words[-1].decode()))

    def get(self, *names: str) -> list[float]:
        read = self.raw.getReal if self.is_first else self.raw.getFloat64
        return list(read([self.references[name] for name in names]))


@contextmanager
def running(name: str, version: str, **start: float) -> Iterator[Instance]:
    instance = Instance(name, version, **start)
    yield instance
    instance.raw.terminate()
    instance.raw.freeInstance()


def expect_slider(names: list[str], phi: Array, **changes: float) -> Array:
    """The model's numbers (names, n) at angles (n,)."""
    lane = own.evaluate_lane(file.load(machine_file(SLIDER), changes), np.array(phi))
    return np.array([lane[name] for name in names])


@needs_compiler
@both_versions
@pytest.mark.parametrize("name", [SLIDER, *FREE])
def test_fmpy_accepts_unit(name: str, version: str) -> None:
    assert validation.validate_fmu(str(unit(name, version))) == []


@needs_compiler
@both_versions
@pytest.mark.parametrize("name", [SLIDER, "cart"])
def test_sources_compile_without_warnings(name: str, version: str, tmp_path: Path) -> None:
    with zipfile.ZipFile(unit(name, version)) as zipped:
        zipped.extractall(tmp_path)
    command = [path_of("gcc"), *STRICT, "-O0", "-fsyntax-only", str(tmp_path / "sources" / "fmu.c")]
    subprocess.run(command, check=True, capture_output=True, text=True)


@needs_compiler
def test_only_interface_is_exported() -> None:
    raw = ctypes.CDLL(str(next(unpack(SLIDER, "2.0").rglob("*.so"))))
    assert raw.fmi2DoStep
    assert not hasattr(raw, "my_slider_crank_2_quantities")


# --- driven machines ---


@needs_compiler
@both_versions
def test_instances_are_tuned_between_steps_and_apart(version: str) -> None:
    names = ["s", "F_Ox"]
    with running(SLIDER, version, speed=3.0) as first, running(SLIDER, version) as second:
        second.set(machine__m_r=1.1, speed=5.0)
        for number in range(5):
            first.raw.doStep(0.1 * number, 0.1)
            second.raw.doStep(0.1 * number, 0.1)
        phi, *values = first.get("phi", *names)
        assert (phi, second.get("phi")[0]) == pytest.approx((1.5, 2.5), rel=1e-14)
        np.testing.assert_allclose(
            values, expect_slider(names, [phi], omega_rpm=90 / np.pi)[:, 0], rtol=1e-10
        )
        tuned = expect_slider(names, [2.5], m_r_kg=1.1, omega_rpm=150 / np.pi)[:, 0]
        np.testing.assert_allclose(second.get(*names), tuned, rtol=1e-10)


@needs_compiler
@both_versions
def test_invalid_design_has_no_outputs(version: str) -> None:
    with running(SLIDER, version) as instance:
        instance.raw.doStep(0.0, 0.1)
        instance.set(design__l=0.04)
        with pytest.raises(Refused):
            instance.get("F_Ox")
        instance.set(design__l=0.2)
        assert np.isfinite(instance.get("F_Ox")).all()
        assert instance.description.modelExchange is None


def test_driven_variables_are_the_values_of_the_file() -> None:
    owner = load_machine(str(machine_file(SLIDER)))
    variables = {variable.name: variable for variable in fmu.build_driven_unit(owner)[0].variables}
    radius, mass = variables["design.r"], variables["machine.m_r"]
    assert (radius.low, radius.high) == pytest.approx((0.03, 0.08))
    assert radius.display_unit == "mm"
    assert (mass.start, mass.low, mass.high, mass.unit) == (0.93, 0.0, None, "kg")
    assert [variable.causality for variable in variables.values()].count("input") == 1
    assert not [name for name in variables if name.startswith(("law_", "pivot_", "states_"))]


# --- free motion ---


@needs_compiler
@both_versions
@pytest.mark.parametrize("use", ["ModelExchange", "CoSimulation"])
@pytest.mark.parametrize("name", ["cart", "cranks", "row_unit"])
def test_free_motion_is_that_of_the_model(name: str, use: str, version: str) -> None:
    """Cart and pendulum from the side; cranks before their flat pose; a wheel that strikes soil."""
    subject, end = model(name), 0.4
    names = [state.name for state in subject.states]
    start = dict(zip(names, subject.start.tolist(), strict=True))
    if name == "cart":
        start["a"] = 0.8
    result = fmpy.simulate_fmu(
        str(unit(name, version)),
        fmi_type=use,
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


@needs_compiler
@both_versions
@pytest.mark.parametrize("name", FREE)
def test_directional_derivatives_are_those_of_the_model(name: str, version: str) -> None:
    subject, instance = model(name), Instance(name, version, "ModelExchange")
    settable = len(subject.states) + len(subject.inputs) + len(subject.parameters)
    count = settable + len(subject.states) + len(subject.outputs)
    unknown = range(settable, count)
    raw = instance.raw
    rows = [raw.getDirectionalDerivative(unknown, [place], [1.0]) for place in range(settable)]
    expected = np.vstack(
        [
            np.hstack(subject.linearised(0.0, subject.start)),
            np.hstack(subject.linearised_outputs(0.0, subject.start)),
        ]
    )
    np.testing.assert_allclose(np.array(rows).T, expected, atol=1e-12 * np.abs(expected).max())
    both = raw.getDirectionalDerivative(unknown, [0, 1], [2.0, -1.0])
    np.testing.assert_allclose(both, 2 * np.array(rows[0]) - rows[1], rtol=1e-12, atol=1e-12)
    states = [raw.getDirectionalDerivative([0, 1], [place], [1.0]) for place in range(3)]
    np.testing.assert_array_equal(states, [[1, 0], [0, 1], [0, 0]])
    for unknowns, knowns in (([len(subject.states)], [0]), ([settable], [settable])):
        with pytest.raises(Refused):
            raw.getDirectionalDerivative(unknowns, knowns, [1.0])


@needs_compiler
@both_versions
def test_step_without_motion_leaves_the_state(version: str) -> None:
    with running("cart", version) as instance:
        instance.set(m_c=0.0, m_p=0.0)
        before = instance.get("s", "a")
        with pytest.raises(Refused):
            instance.raw.doStep(0.0, 0.1)
        assert instance.get("s", "a") == before
        instance.set(m_c=1.0, m_p=0.3, F=2.0)
        instance.raw.doStep(0.0, 0.1)
        assert instance.get("s")[0] > before[0]


@needs_compiler
@both_versions
def test_weak_constraints_are_told_once_with_their_time(version: str) -> None:
    """Parallel cranks at their flat pose and away from it, by either use."""
    subject = model("cranks")
    flat = np.array([1e-6, 1e-6, 1e-6, 0, 0, 0, 0, 0])
    instance = Instance("cranks", version, "ModelExchange")
    read = (
        instance.raw.getDerivatives
        if version == "2.0"
        else instance.raw.getContinuousStateDerivatives
    )
    rates = (ctypes.c_double * 8)()
    instance.raw.enterContinuousTimeMode()
    for number, state in enumerate((subject.start, flat, 2 * flat, subject.start, flat)):
        instance.raw.setTime(number / 4)
        vector = (ctypes.c_double * 8)(*state)
        instance.raw.setContinuousStates(vector, 8)
        read(rates, 8)
        assert instance.get("pivot")[0] == pytest.approx(subject.pivot(0.0, state), rel=1e-9)
    assert [status for status, _ in instance.messages] == [WARNING, WARNING]
    for (_, text), time in zip(instance.messages, ("0.25", "1"), strict=True):
        assert text.startswith(f"at {time} s: ")
    names = [state.name for state in subject.states]
    with running("cranks", version) as regular:
        regular.raw.doStep(0.0, 0.01)
        assert regular.messages == []
        regular.set(**dict(zip(names, flat.tolist(), strict=True)))
        regular.raw.doStep(0.01, 0.01)
        assert [status for status, _ in regular.messages] == [WARNING]
        assert regular.messages[0][1].startswith("at 0.01 s: ")


@needs_compiler
@both_versions
def test_wrong_starts_are_told_and_leave_the_unit_usable(version: str) -> None:
    """Masses of zero have no motion; another start has one."""
    with running("cart", version, m_c=0.0, m_p=0.0) as instance:
        with pytest.raises(Refused):
            instance.get("der(s)")
        status, text = instance.messages[0]
        assert (status, text) == (DISCARD, "at 0 s: a rate or an output is not finite")
        instance.set(m_c=1.0, m_p=0.3, F=2.0)
        assert instance.get("der(s_dot)")[0] == pytest.approx(2.0)


@needs_compiler
@both_versions
def test_unit_ends_in_the_middle_and_begins_anew(version: str) -> None:
    """A step after the end is refused; a reset brings the start back; another instance is apart."""
    with running("cart", version, F=3.0) as instance, running("cart", version) as other:
        before = instance.get("s", "F", "der(s_dot)")
        instance.raw.doStep(0.0, 0.1)
        instance.raw.terminate()
        with pytest.raises(Refused):
            instance.raw.doStep(0.1, 0.1)
        instance.raw.reset()
        assert instance.get("s", "F") == [0.0, 0.0]
        instance.set(F=3.0)
        if instance.is_first:
            instance.raw.setupExperiment(startTime=0.0)
        instance.raw.enterInitializationMode()
        instance.raw.exitInitializationMode()
        assert instance.get("s", "F", "der(s_dot)") == before
        other.raw.doStep(0.0, 0.1)
        assert other.get("s") == [0.0]


PUSH = np.array([(0.0, 0.0), (0.2, 3.0), (0.4, 3.0)])
"""Times [s] and pushes [N]: a ramp, then a constant."""


def expect_pushed_cart(folder: Path, times: Array) -> Array:
    """Places of the cart by the model, which reads the push from a file."""
    path = folder / "push.csv"
    rows = "".join(f"{time},{push}\n" for time, push in PUSH)
    path.write_text(f"t_s,F_N\n{rows}", encoding="utf-8")
    cart = file.load(find_path("cart"), {})
    return Dynamics(cart, read_history(path, cart)).run(times).states[0]


@needs_compiler
@both_versions
def test_input_is_held_over_a_step_of_cosimulation(version: str, tmp_path: Path) -> None:
    """An error of first order falls by half with half the step."""
    errors = []
    for step in (0.004, 0.002):
        times = np.arange(0, 0.4 + step / 2, step)
        result = fmpy.simulate_fmu(
            str(unit("cart", version)),
            fmi_type="CoSimulation",
            stop_time=0.4,
            output_interval=step,
            input=np.array([*map(tuple, PUSH)], dtype=[("time", float), ("F", float)]),
            output=["s"],
        )
        moved = np.interp(times, result["time"], result["s"])
        errors.append(np.abs(moved - expect_pushed_cart(tmp_path, times)).max())
    assert errors[0] < 5e-3
    assert errors[0] / errors[1] == pytest.approx(2, rel=0.05)


# --- both ---


@needs_compiler
@both_versions
@pytest.mark.parametrize(
    ("name", "tuned", "computed"), [(SLIDER, "speed", "F_Ox"), ("cart", "F", "der(s)")]
)
def test_state_is_saved_and_restored(name: str, tuned: str, computed: str, version: str) -> None:
    """In memory and as bytes, also by another instance; bytes of something else are refused."""
    with running(name, version) as instance, running(name, version) as other:
        instance.set(**{tuned: 3.0})
        instance.raw.doStep(0.0, 0.3)
        then, saved = instance.get(tuned, computed), instance.raw.getFMUState()
        stored = instance.raw.serializeFMUState(saved)
        instance.set(**{tuned: 6.0})
        instance.raw.doStep(0.3, 0.2)
        assert np.abs(np.subtract(instance.get(tuned, computed), then)).min() > 1e-3
        instance.raw.setFMUState(saved)
        assert instance.get(tuned, computed) == then
        other.raw.setFMUState(other.raw.deserializeFMUState(stored))
        assert other.get(tuned, computed) == then
        instance.raw.freeFMUState(saved)
        with pytest.raises(Refused):
            other.raw.deserializeFMUState(b"x" + stored[1:])


@needs_compiler
@both_versions
@pytest.mark.parametrize(
    ("name", "tuned", "computed"), [(SLIDER, "speed", "phi"), ("cart", "s", "der(s)")]
)
def test_invalid_request_is_refused(name: str, tuned: str, computed: str, version: str) -> None:
    with running(name, version) as instance:
        for wrong in ({tuned: float("nan")}, {computed: 1.0}):
            with pytest.raises(Refused):
                instance.set(**wrong)
        with pytest.raises(Refused):
            instance.raw.doStep(0.0, -0.1)
        instance.references["nothing"] = 10_000
        with pytest.raises(Refused):
            instance.get("nothing")


@pytest.mark.long
def test_library_for_windows(tmp_path: Path) -> None:
    """Where the extra `compiler` is installed."""
    pytest.importorskip("ziglang")
    record = fmu.write_unit(load_machine(str(machine_file(SLIDER))), tmp_path / "a.fmu")
    assert record.platforms == ["linux64", "win64"]
    with zipfile.ZipFile(tmp_path / "a.fmu") as zipped:
        content = zipped.read("binaries/win64/my_slider_crank_2.dll")
    assert content.startswith(b"MZ")
    assert b"fmi2DoStep" in content


@pytest.mark.parametrize(
    ("unit", "expected"),
    [
        ("1", {}),
        ("kg m2", {"kg": 1, "m": 2}),
        ("N m/rad", {"kg": 1, "m": 2, "s": -2, "rad": -1}),
        ("s/m", {"s": 1, "m": -1}),
        ("W", decompose_unit("N m/s")),
        ("J", decompose_unit("W s")),
        ("N", decompose_unit("J/m")),
    ],
)
def test_units_are_decomposed(unit: str, expected: dict[str, int]) -> None:
    assert decompose_unit(unit) == expected


@pytest.mark.parametrize("unit", ["mm", "furlong"])
def test_invalid_si_units_are_refused(unit: str) -> None:
    with pytest.raises(ValueError, match="is not a unit"):
        decompose_unit(unit)
