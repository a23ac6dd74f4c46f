"""The composed device: names from families, refused geometry, a family of one's own."""

import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.special

import planter
from derive.discovery import load_user_modules
from derive.emit.folder import emit_curve
from derive.emit.targets import casadi
from derive.generated_folder import GENERATED
from derive.mechanics.gearing.families import FAMILIES
from derive.mechanics.gearing.pitch_curve import PitchCurve
from planter.errors import GeometryError, InputError
from planter.files import examples
from planter.gears.geometry import families as curves
from planter.kernels import generated
from planter.papers.planting import file
from planter.papers.planting.functions import MODELS, Model
from planter.papers.planting.model import Device
from tests.support.sizing import Size, Sizing

TEN = (
    "theta_deg",
    "gamma_deg",
    "alpha3_deg",
    "beta6_deg",
    "R3_mm",
    "e3_mm",
    "m31",
    "A6_mm",
    "k6",
    "m61",
)


def edited(tmp_path: Path, *changes: tuple[str, str]) -> Path:
    text = examples.example("wang2017")
    for old, new in changes:
        assert re.search(old, text, re.MULTILINE), old
        text = re.sub(old, new, text, count=1, flags=re.MULTILINE)
    path = tmp_path / "my.toml"
    path.write_text(text)
    return path


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("name", examples.list_examples("planting"))
def test_names_and_numbers_of_built_in_machines(name: str, model: Model) -> None:
    device = Device(file.load(name), model)
    assert device.names == TEN
    assert device.design * np.array(
        [1e3 if n.endswith("_mm") else 1 for n in TEN]
    ) == pytest.approx(
        [
            np.radians(device.machine.design[n]) if n.endswith("_deg") else device.machine.design[n]
            for n in TEN
        ]
    )
    assert (device.lower < device.upper).all()


def test_no_list_of_the_ten_names_stands_in_planter() -> None:
    folder = Path(planter.__file__).parent
    for path in folder.rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        named = [name for name in TEN if re.search(rf"""["']{name}["']""", text)]
        assert len(named) < 4, (path, named)


BAD_GEOMETRY = {
    "m at one half": (
        [(r"^m31 = .*", "m31 = 0.5")],
        "design.m31 = 0.5: it must be greater than 1/2",
    ),
    "e at R": (
        [(r"^e3_mm = .*", "e3_mm = 30.916")],
        "design.e3_mm = 30.916: it must be less than R",
    ),
    "k at one": ([(r"^k6 = .*", "k6 = 1.0")], "design.k6 = 1: it must be less than 1"),
    "negative radius": (
        [(r"^A6_mm = .*", "A6_mm = -3")],
        "design.A6_mm = -3: it must be greater than 0",
    ),
    "bounds that let k reach one": ([(r"^k6 = \[.*", "k6 = [0.03, 1.2]")], "bounds.k6 = 1.2:"),
    "unknown family": (
        [(r'^family = "ellipse"', 'family = "elipse"')],
        'stage2.family = "elipse": did you mean ellipse?',
    ),
    "a name of another family": ([(r"^R3_mm = 30.916", "A3_mm = 30.9")], "A3_mm"),
    "not converged": ([(r"^e3_mm = .*", "e3_mm = 30.9155")], "has not converged"),
}


@pytest.mark.parametrize("case", BAD_GEOMETRY)
def test_impossible_geometry_is_named(case: str, tmp_path: Path) -> None:
    changes, sentence = BAD_GEOMETRY[case]
    with pytest.raises(InputError) as caught:
        Device(file.load(edited(tmp_path, *changes)))
    assert "my.toml" in caught.value.message
    assert sentence in caught.value.message
    assert "\n" not in caught.value.message


NEW_FAMILY = '''
"""A family that nobody has written yet."""

import sympy as sp

from derive.mechanics.gearing.pitch_curve import Condition, PitchCurve, register, swing, u
from derive.quantity import Quantity


@register
class Exponential(PitchCurve):
    """r = R exp(b cos u)."""

    name = "exponential"
    title = "deformed exponential curve"
    R = Quantity("R", "m", "geometric mean radius", "test", shown="R_mm")
    b = Quantity("b", "1", "logarithm of the largest radius over R", "test", shown="b")
    parameters = (R, b)

    def radius(self):
        return self.R * sp.exp(self.b * sp.cos(u))

    def conditions(self):
        return [Condition("R", self.R, "greater than 0"), Condition("b", self.b, "greater than 0")]

    def relative(self):
        return sp.Integer(1), sp.log((1 + swing) / (1 - swing)) / 4
'''


@pytest.fixture
def with_new_family(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[None]:
    """One new file among the families, and what `python -m derive` then writes among what it wrote
    before.
    """
    (tmp_path / "exponential.py").write_text(NEW_FAMILY)
    with load_user_modules(tmp_path / "exponential.py"):
        pass
    _generated_beside(tmp_path / "with_new_family", FAMILIES["exponential"])
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(generated, "_package", lambda: "with_new_family")
    cached = (
        generated._places,
        generated.module,
        generated.sidecar,
        curves.load_functions,
        curves.load_sidecar,
    )
    for function in cached:
        function.cache_clear()
    yield
    del FAMILIES["exponential"]
    for name in [
        n for n in sys.modules if n.startswith("with_new_family") or n == "derive_own_exponential"
    ]:
        del sys.modules[name]
    for function in cached:
        function.cache_clear()


def _generated_beside(folder: Path, family: PitchCurve) -> None:
    folder.mkdir()
    for path in GENERATED.iterdir():
        (folder / path.name).symlink_to(path)
    for path, content in emit_curve(family, [casadi.TARGET]).items():
        (folder / path).write_text(content)


@pytest.mark.usefixtures("with_new_family")
def test_new_family_changes_no_others(tmp_path: Path) -> None:
    """One class in one file makes a device: names, closure, rotation, gradients, size and
    requirements come along.
    """
    size = Size(mean_radius=0.0307, swing=0.1, deformation=1.26)
    R, b, _ = Sizing("exponential").parameters(size)
    path = edited(
        tmp_path,
        (r'^family = "ellipse"', 'family = "exponential"'),
        (r"^A6_mm = 30.*", f"R6_mm = {R * 1e3}"),
        (r"^k6 = 0.*", f"b6 = {b}"),
        (r"^A6_mm = \[.*", "R6_mm = [30, 31]"),
        (r"^k6 = \[.*", "b6 = [0.01, 0.1]"),
    )
    device = Device(file.load(path))
    assert device.names[7:] == ("R6_mm", "b6", "m61")
    recovered = Sizing("exponential").size(device.design[7:])
    assert [recovered.mean_radius, recovered.swing] == pytest.approx([0.0307, 0.1], rel=1e-12)
    assert recovered.mean_radius == pytest.approx(R * scipy.special.i0(b), rel=1e-13)
    at = device.prologue(device.design)
    turn = 2 * np.pi * np.arange(64) / 64
    assert mean_ratio(R, b, at.h[1 + device.stages[0].terms], turn) == pytest.approx(1, abs=1e-13)
    phi = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    assert device.support(at, phi).mean() == pytest.approx(9.975 * 9.81, abs=1e-3)
    slope = device.support_slopes(at, phi[:5])[1][:, 1 + 8]
    for side in (1e-6, -1e-6):
        moved = device.design + side * np.eye(device.size)[8]
        difference = device.support(device.prologue(moved), phi[:5]) - device.support(at, phi[:5])
        assert difference / side == pytest.approx(slope, rel=1e-3)


def mean_ratio(R: float, b: float, distance: float, u: np.ndarray) -> float:
    r = R * np.exp(b * np.cos(u))
    return float(np.mean(r / (distance - r)))


def test_missing_family_file_removes_family(tmp_path: Path) -> None:
    assert "exponential" not in FAMILIES
    with pytest.raises(InputError, match=r'stage2.family = "exponential": it must be one of'):
        Device(file.load(edited(tmp_path, (r'^family = "ellipse"', 'family = "exponential"'))))


def test_radius_beyond_centre_distance_is_named_with_angle() -> None:
    """A stage whose prologue is told a centre distance that is too short."""
    stage = Device(file.load("wang2017")).stages[1]
    from planter.gears.geometry.stage import StageCandidate

    class Short(type(stage)):  # type: ignore[misc]
        @property
        def prologue(self) -> Any:
            return lambda parameters: {"hoisted": np.array([[0.031]])}

    short = Short(stage.family, stage.names)
    with pytest.raises(GeometryError, match=r"deformed ellipse r = .* mm at t = 0 deg:"):
        short.check_radius(
            StageCandidate(
                np.array([0.030694, 0.031, 1.26]), lambda name: f"my.toml: design.{name}"
            )
        )
