"""Mechanisms of one's own in tests: derived into a folder, loaded from there."""

from __future__ import annotations

import hashlib
import importlib.util
import shutil
import sys
from functools import cache
from pathlib import Path
from tempfile import mkdtemp
from types import ModuleType

import sympy

from derive.__main__ import main as derive
from planter.engine.machine import Machine
from planter.kernels import Array
from planter.mechanism.dynamics import Dynamics
from planter.mechanism.file import MechanismFile, load
from planter.mechanism.machines import build_machine
from tests.support.structure import ROOT

EXAMPLES = ROOT / "docs" / "examples"
DERIVED = ROOT / ".pytest_cache" / "derived"
LIBRARY = (
    "belt_drive",
    "cart_pole",
    "coupler_path",
    "crank_rocker",
    "eccentric_train",
    "gear_rattle",
    "geared_five_bar",
    "geneva_wheel",
    "hay_baler",
    "hooke_joint",
    "internal_gears",
    "lift_arm",
    "measured_gears",
    "pendulum",
    "pin_clearance",
    "planetary_gear",
    "rack_press",
    "radial_pump",
    "released_device",
    "released_press",
    "released_train",
    "rotary_transplanter",
    "row_unit",
    "rssr",
    "scotch_yoke",
    "spinning_top",
    "stephenson_six_bar",
    "swash_plate",
    "tabulated_cam",
    "toggle_press",
    "watt_six_bar",
)
"""Machines of the library of examples, each with its tests in the folder `mechanism`."""


@cache
def generated(source: str) -> Path:
    """The folder of what is generated of a statement: the name of an example, or a text.

    It is a copy; what was derived stays for other processes and runs, as long as nothing that it
    depends on changes.
    """
    is_example = "\n" not in source
    text = (EXAMPLES / f"{source}.py").read_text("utf-8") if is_example else source
    path = Path(mkdtemp()) / f"{source if is_example else 'own'}.py"
    path.write_text(text, encoding="utf-8")
    for curve in EXAMPLES.glob("*.csv"):
        shutil.copy(curve, path.parent)
    cached = DERIVED / hashlib.sha256(f"{_digest()}{path.name}{text}".encode()).hexdigest()[:24]
    target = path.parent / "generated"
    if cached.is_dir():
        shutil.copytree(cached, target)
        return target
    assert derive([str(path)]) == 0
    partial = Path(mkdtemp(dir=DERIVED))
    shutil.copytree(target, partial, dirs_exist_ok=True)
    try:
        partial.rename(cached)
    except OSError:  # another process was first
        shutil.rmtree(partial)
    return target


@cache
def _digest() -> str:
    """A digest of what derives, and of the curves that statements read."""
    DERIVED.mkdir(parents=True, exist_ok=True)
    files = [*sorted((ROOT / "derive").rglob("*.py")), *sorted(EXAMPLES.glob("*.csv"))]
    digest = hashlib.sha256(f"{sys.version}{sympy.__version__}".encode())
    for path in files:
        digest.update(path.read_bytes())
    return digest.hexdigest()


def file(source: str, name: str = "", **values: float) -> MechanismFile:
    """The file of a mechanism, some values set; ``name`` that of the statement, if it is no
    example's.
    """
    return load(generated(source) / f"{name or source}.toml", values)


def machine(source: str, name: str = "", **values: float) -> Machine:
    """Return the machine of a mechanism that an angle drives."""
    return build_machine(file(source, name, **values))


def evaluate_lane(
    file: MechanismFile, angles: Array, data: Array | None = None
) -> dict[str, Array]:
    """Return quantities (n,) by name as the generated functions have them, its loops closed by a
    walk.
    """
    formulas, values = file.model, file.data() if data is None else data
    loops = build_machine(file).loops
    closed = {} if loops is None else {"loops": loops.course(file.name, values).evaluate(angles)}
    return formulas(
        "lane", **{formulas.function("lane").name_in(0): angles, "data": values, **closed}
    )


def dynamics(source: str, name: str = "", **values: float) -> Dynamics:
    return Dynamics(file(source, name, **values))


def array_code(source: str, name: str = "") -> ModuleType:
    """The array code of a mechanism, for any module of elementary functions."""
    return import_file(generated(source) / "array" / f"{name or source}.py")


def import_file(path: Path) -> ModuleType:
    """Return the module of a file."""
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[path.stem] = module  # which dataclasses look up
    spec.loader.exec_module(module)
    return module


def deviation(description: str, actual: object, printed: object) -> float:
    """The largest deviation from printed numbers, told on standard output."""
    import numpy as np

    largest = float(np.abs(np.asarray(actual) - np.asarray(printed)).max())
    print(f"{description}: deviation {largest:.1e}")
    return largest
