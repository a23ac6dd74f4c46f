"""A device as a unit for co-simulation, run by FMPy: it finds what `planter simulate` finds."""

import ctypes
import subprocess
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from planter.engine.machine import Machine
from planter.exports import co_simulation, fmu
from planter.exports.quantities import list_quantities
from planter.files import units
from planter.kernels import Array
from planter.papers.planting.file import load
from planter.papers.planting.functions import Model
from planter.papers.planting.model import Device, build_machine
from tests.support import swapped
from tests.support.lanes import STRICT, needs_compiler, path_of

fmpy = pytest.importorskip("fmpy", reason="FMPy is not installed")
validation = pytest.importorskip("fmpy.validation")
pytestmark = needs_compiler


UNITS: dict[str, tuple[Model, str]] = {
    "exact": ("exact", "2.0"),
    "printed": ("printed", "2.0"),
    "exact 3.0": ("exact", "3.0"),
}
both_versions = pytest.mark.parametrize("unit", ["exact", "exact 3.0"])


@pytest.fixture(scope="module")
def quick() -> Iterator[None]:
    """Only the library of this system, compiled without passes."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            co_simulation,
            "PLATFORMS",
            {k: v for k, v in co_simulation.PLATFORMS.items() if k == "linux64"},
        )
        patch.setattr(co_simulation, "FLAGS", ("-O0", *co_simulation.FLAGS[1:]))
        yield


@pytest.fixture(scope="module")
def written(quick: None, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A unit of each model, of another machine each, and of each version of FMI, by their names."""
    folder = tmp_path_factory.mktemp("units")
    values = {}
    for name, (model, version) in UNITS.items():
        fmu.write_unit(unit_machine(model), folder / f"{name}.fmu", version)
        values[name] = folder / f"{name}.fmu"
    return values


def device(model: Model) -> Device:
    return Device(swapped.machine() if model == "printed" else load("wang2017"), model)


def unit_machine(model: Model) -> Machine:
    return build_machine(device(model))


class Slave:
    """A unit that FMPy has instantiated."""

    def __init__(self, file: Path, folder: Path, name: str = "one") -> None:
        self.description = fmpy.read_model_description(str(file))
        if not folder.exists():
            fmpy.extract(str(file), str(folder))
        self.references = {v.name: v.valueReference for v in self.description.modelVariables}
        self.first = self.description.fmiVersion == "2.0"
        self.raw = (fmpy.fmi2.FMU2Slave if self.first else fmpy.fmi3.FMU3Slave)(
            guid=self.description.guid,
            unzipDirectory=str(folder),
            instanceName=name,
            modelIdentifier=self.description.coSimulation.modelIdentifier,
        )
        self.raw.instantiate()
        if self.first:
            self.raw.setupExperiment(startTime=0.0)

    def set(self, **values: float) -> None:
        names = [name.replace("__", ".") for name in values]
        write = self.raw.setReal if self.first else self.raw.setFloat64
        write([self.references[name] for name in names], list(values.values()))

    def get(self, *names: str) -> Array:
        read = self.raw.getReal if self.first else self.raw.getFloat64
        return np.array(read([self.references[name] for name in names]))

    def start(self) -> None:
        self.raw.enterInitializationMode()
        self.raw.exitInitializationMode()


@contextmanager
def running(file: Path, folder: Path, **values: float) -> Iterator[Slave]:
    slave = Slave(file, folder)
    slave.set(**values)
    slave.start()
    yield slave
    slave.raw.terminate()
    slave.raw.freeInstance()


def names(owner: Device) -> list[str]:
    """Names of the outputs but the angle, as the unit has them."""
    return [fmu.build_output_name(quantity) for quantity in list_quantities(build_machine(owner))]


def expected(owner: Device, phi: Array) -> Array:
    """The same numbers as `simulate` has them, in SI, (quantities, n)."""
    columns = owner.columns(owner.design, phi)
    del columns["phi_deg"]
    return np.array([column * units.unit_factor(key) for key, column in columns.items()])


@pytest.mark.parametrize("unit", UNITS)
def test_fmpy_accepts_the_unit(unit: str, written: dict[str, Path]) -> None:
    assert validation.validate_fmu(str(written[unit])) == []


@both_versions
def test_design_and_machine_can_be_tuned_between_steps(
    unit: str, written: dict[str, Path], tmp_path: Path
) -> None:
    machine = load("wang2017", {"mass.sun_kg": 2.5, "operation.speed_rpm": 44.0})
    owner = Device(machine)
    x = owner.x(R3_mm=31.0, m61=0.97)
    with running(written[unit], tmp_path / "unit") as slave:
        before = slave.get("F_support")
        slave.raw.doStep(0.0, 0.1)
        slave.set(machine__m1=2.5, speed=44 * np.pi / 30, design__R3=0.031, design__m61=0.97)
        phi, *values = slave.get("phi", *names(owner))
        assert phi == pytest.approx(0.1 * own_speed(), rel=1e-14)
        columns = owner.columns(x, np.array([phi]))
        del columns["phi_deg"]
        expected = [column[0] * units.unit_factor(key) for key, column in columns.items()]
        np.testing.assert_allclose(values, expected, rtol=1e-10, atol=1e-12)
        assert values[names(owner).index("F_support")] != pytest.approx(before[0], rel=1e-3)


def own_speed() -> float:
    return load("wang2017").si("operation.speed_rpm")


@both_versions
def test_two_instances_do_not_disturb_each_other(
    unit: str, written: dict[str, Path], tmp_path: Path
) -> None:
    """Of one library."""
    folder, file = tmp_path / "unit", written[unit]
    with running(file, folder) as first, running(file, folder, speed=5.0) as second:
        second.set(machine__m1=3.0)
        for number in range(5):
            first.raw.doStep(0.1 * number, 0.1)
            second.raw.doStep(0.1 * number, 0.1)
        values, speeds = (
            first.get(*names(device("exact"))),
            (first.get("phi")[0], second.get("phi")[0]),
        )
        assert speeds == pytest.approx((0.5 * own_speed(), 2.5), rel=1e-14)
        expected_outputs = expected(device("exact"), np.array([speeds[0]]))[:, 0]
        np.testing.assert_allclose(values, expected_outputs, rtol=1e-10, atol=1e-12)


@both_versions
def test_a_state_is_saved_and_restored(unit: str, written: dict[str, Path], tmp_path: Path) -> None:
    """In memory and as bytes, also by another instance; bytes of something else are refused."""
    output_names = ["phi", "speed", "design.R3", *names(device("exact"))]
    folder, file = tmp_path / "unit", written[unit]
    with running(file, folder) as slave, running(file, folder) as other:
        slave.raw.doStep(0.0, 0.3)
        slave.set(design__R3=0.0305)
        then, saved = slave.get(*output_names), slave.raw.getFMUState()
        stored = slave.raw.serializeFMUState(saved)
        slave.set(speed=6.0, design__R3=0.031)
        slave.raw.doStep(0.3, 0.2)
        assert np.abs(slave.get(*output_names) - then).max() > 0.1
        slave.raw.setFMUState(saved)
        assert slave.get(*output_names).tolist() == then.tolist()
        other.raw.setFMUState(other.raw.deserializeFMUState(stored))
        assert other.get(*output_names).tolist() == then.tolist()
        slave.raw.freeFMUState(saved)
        with pytest.raises(fmpy.fmi1.FMICallException):
            other.raw.deserializeFMUState(b"x" + stored[1:])


@both_versions
def test_invalid_request_is_refused(unit: str, written: dict[str, Path], tmp_path: Path) -> None:
    with running(written[unit], tmp_path / "unit") as slave:
        for wrong in ({"speed": float("nan")}, {"phi": 1.0}):
            with pytest.raises(fmpy.fmi1.FMICallException):
                slave.set(**wrong)
        with pytest.raises(fmpy.fmi1.FMICallException):
            slave.raw.doStep(0.0, -0.1)
        slave.references["nothing"] = 10_000
        with pytest.raises(fmpy.fmi1.FMICallException):
            slave.get("nothing")
        slave.raw.doStep(0.0, 0.1)
        slave.set(design__R3=0.0)
        with pytest.raises(fmpy.fmi1.FMICallException):
            slave.get("F_support")
        slave.set(design__R3=0.03)
        assert np.isfinite(slave.get("F_support"))


@both_versions
def test_sources_compile_without_warnings(
    unit: str, written: dict[str, Path], tmp_path: Path
) -> None:
    """Those that the unit holds, by another compiler's flags."""
    with zipfile.ZipFile(written[unit]) as zipped:
        zipped.extractall(tmp_path)
    command = [path_of("gcc"), *STRICT, "-O0", "-fsyntax-only", str(tmp_path / "sources" / "fmu.c")]
    subprocess.run(command, check=True, capture_output=True, text=True)


def test_only_the_interface_is_exported(written: dict[str, Path], tmp_path: Path) -> None:
    with zipfile.ZipFile(written["exact"]) as zipped:
        library = zipped.extract("binaries/linux64/wang2017.so", tmp_path)
    raw = ctypes.CDLL(library)
    assert raw.fmi2DoStep
    assert not hasattr(raw, "wang2017_quantities")


@pytest.mark.long
def test_a_library_for_windows(tmp_path: Path) -> None:
    """Where the extra `compiler` is installed."""
    pytest.importorskip("ziglang")
    unit = fmu.write_unit(unit_machine("exact"), tmp_path / "a.fmu")
    assert unit.platforms == ["linux64", "win64"]
    with zipfile.ZipFile(tmp_path / "a.fmu") as zipped:
        content = zipped.read("binaries/win64/wang2017.dll")
    assert content.startswith(b"MZ")
    assert b"fmi2DoStep" in content
