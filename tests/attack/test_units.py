"""Functions of units (FMI) refuse what an importer must not hand in, and crash on
nothing.
"""

from __future__ import annotations

import ctypes
import re
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from tempfile import mkdtemp
from zipfile import ZipFile

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.attack.test_attack import share
from tests.planter.exports.exported import machine_file
from tests.planter.mechanism.state_space.test_model import find_path
from tests.support.cli import answer
from tests.support.lanes import needs_compiler
from tests.support.units import quick_libraries

pytestmark = needs_compiler
OK, ERROR = 0, 3
SPECIAL = ("Instantiate", "FreeInstance", "GetTypesPlatform", "GetVersion")
"""Beginnings of functions that return no status."""
CALL_ALL = """
import ctypes, sys
library = ctypes.CDLL(sys.argv[1])
for name in sys.argv[2:]:
    function = getattr(library, name)
    function.restype = ctypes.c_int
    print(name, function(*[ctypes.c_void_p(0)] * 14), flush=True)
"""


@cache
def build_unit(version: str, is_free: bool = False) -> tuple[Path, str]:
    """Return the library of a unit and the token of its description."""
    folder = Path(mkdtemp())
    path = find_path("cart") if is_free else machine_file("slider_crank")
    with quick_libraries():
        out = str(folder / "unit.fmu")
        record = answer("export fmu", str(path), "--fmi", version, "--out", out)
    with ZipFile(folder / "unit.fmu") as packed:
        packed.extractall(folder)
    return next(folder.rglob("*.so")), record["token"]


def list_functions(library: Path, prefix: str) -> list[str]:
    names = set(re.findall(rf"\b{prefix}[A-Z]\w+", library.read_bytes().decode("latin-1")))
    loaded = ctypes.CDLL(str(library))
    return sorted(name for name in names if hasattr(loaded, name))


@pytest.mark.parametrize("is_free", [False, True])
@pytest.mark.parametrize(("version", "prefix"), [("2.0", "fmi2"), ("3.0", "fmi3")])
def test_no_function_crashes_without_an_instance(version: str, prefix: str, is_free: bool) -> None:
    library = build_unit(version, is_free)[0]
    functions = list_functions(library, prefix)
    functions = [name for name in functions if not name.removeprefix(prefix).startswith(SPECIAL)]
    assert len(functions) >= 25
    done = subprocess.run(
        [sys.executable, "-c", CALL_ALL, str(library), *functions],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.returncode == 0, done
    assert dict(line.split() for line in done.stdout.splitlines()) == dict.fromkeys(
        functions, str(ERROR)
    )


class Unit:
    """An instance of a unit of FMI 2.0 that has been initialised at a time [s]."""

    def __init__(self, start: float = 0.0) -> None:
        path, token = build_unit("2.0")
        self.library = ctypes.CDLL(str(path))
        self.library.fmi2Instantiate.restype = ctypes.c_void_p
        arguments = (b"unit", 1, token.encode(), None, None, 0, 0)
        self.instance = ctypes.c_void_p(self.library.fmi2Instantiate(*arguments))
        assert self.instance.value
        number = ctypes.c_double
        self.library.fmi2SetupExperiment(self.instance, 0, number(0), number(start), 0, number(0))
        self.library.fmi2EnterInitializationMode(self.instance)
        self.library.fmi2ExitInitializationMode(self.instance)

    def step(self, time: float, step: float) -> int:
        """Return the status of a step."""
        status: int = self.library.fmi2DoStep(
            self.instance, ctypes.c_double(time), ctypes.c_double(step), 1
        )
        return status

    def close(self) -> None:
        self.library.fmi2FreeInstance(self.instance)


@pytest.fixture
def unit() -> Iterator[Unit]:
    unit = Unit()
    yield unit
    unit.close()


def test_steps_follow_each_other(unit: Unit) -> None:
    assert [unit.step(i * 0.1, 0.1) for i in range(1000)] == [
        OK
    ] * 1000  # i * 0.1 is not the sum of steps
    assert unit.step(50.0, 0.1) == ERROR
    assert unit.step(100.0, float("nan")) == ERROR
    assert unit.step(100.0, -0.1) == ERROR
    assert unit.step(100.0, 0.1) == OK
    assert unit.step(100.0, 0.1) == ERROR


@share
@given(
    steps=st.lists(st.floats(1e-6, 10), min_size=1, max_size=8),
    start=st.floats(-10, 10),
    gap=st.sampled_from([0.0, 1e-3, -1e-3, 1.0, 1e9, float("inf"), float("nan")]),
)
def test_communication_point_that_does_not_follow_is_refused(
    steps: list[float], start: float, gap: float
) -> None:
    unit, time = Unit(start), start
    for step in steps:
        assert unit.step(time, step) == OK
        time += step
    assert unit.step(time + gap, 0.5) == (ERROR if gap else OK)
    unit.close()


def test_arrays_that_are_missing_are_refused(unit: Unit) -> None:
    for function in ("fmi2SetReal", "fmi2GetReal"):
        assert (
            getattr(unit.library, function)(unit.instance, None, ctypes.c_size_t(3), None) == ERROR
        )
        assert getattr(unit.library, function)(unit.instance, None, ctypes.c_size_t(0), None) == OK
    assert unit.library.fmi2GetFMUstate(unit.instance, None) == ERROR
    assert unit.library.fmi2Reset(unit.instance) == OK
