"""The composed device: names from families, refused geometry, a family of one's own."""

import json
import re
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
import sympy as sp
from sympy import Expr

import planter
from derive import curves
from derive.curves import Condition, PitchCurve
from derive.emit import curve as emit_curve
from derive.emit import sidecar as emit_sidecar
from derive.quantity import Quantity
from planter import builtin, emitted, machine
from planter.device import MODELS, Device, Model
from planter.errors import GeometryError, InputError

TEN = ("theta_deg", "gamma_deg", "alpha3_deg", "beta6_deg", "R3_mm", "e3_mm", "m31", "A6_mm", "k6", "m61")


def edited(tmp_path: Path, *changes: tuple[str, str]) -> Path:
    text = builtin.example("wang2017")
    for old, new in changes:
        assert re.search(old, text, re.MULTILINE), old
        text = re.sub(old, new, text, count=1, flags=re.MULTILINE)
    path = tmp_path / "my.toml"
    path.write_text(text)
    return path


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("name", builtin.names("planting"))
def test_names_and_numbers_of_built_in_machines(name: str, model: Model) -> None:
    device = Device(machine.load(name), model)
    assert device.names == TEN
    assert device.design * np.array([1e3 if n.endswith("_mm") else 1 for n in TEN]) == pytest.approx(
        [np.radians(device.machine.design[n]) if n.endswith("_deg") else device.machine.design[n] for n in TEN]
    )
    assert (device.lower < device.upper).all()


def test_no_list_of_the_ten_names_stands_in_planter() -> None:
    folder = Path(planter.__file__).parent
    for path in folder.rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        named = [name for name in TEN if re.search(rf"""["']{name}["']""", text)]
        assert len(named) < 4, (path, named)


BAD_GEOMETRY = {
    "m at one half": ([(r"^m31 = .*", "m31 = 0.5")], "design.m31 = 0.5 is not allowed: it must be greater than 1/2"),
    "e at R": ([(r"^e3_mm = .*", "e3_mm = 30.916")], "design.e3_mm = 30.916 is not allowed: it must be less than R"),
    "k at one": ([(r"^k6 = .*", "k6 = 1.0")], "design.k6 = 1 is not allowed: it must be less than 1"),
    "negative radius": (
        [(r"^A6_mm = .*", "A6_mm = -3")],
        "design.A6_mm = -3 is not allowed: it must be greater than 0",
    ),
    "bounds that let k reach one": ([(r"^k6 = \[.*", "k6 = [0.03, 1.2]")], "bounds.k6 = 1.2 is not allowed"),
    "unknown family": (
        [(r'^family = "ellipse"', 'family = "elipse"')],
        "stage2.family = 'elipse' is not allowed: it must be",
    ),
    "a name of another family": ([(r"^R3_mm = 30.916", "A3_mm = 30.9")], "A3_mm"),
    "not converged": ([(r"^e3_mm = .*", "e3_mm = 30.9155")], "has not converged"),
}


@pytest.mark.parametrize("case", BAD_GEOMETRY)
def test_geometry_that_cannot_be_built_is_named(case: str, tmp_path: Path) -> None:
    changes, sentence = BAD_GEOMETRY[case]
    with pytest.raises(InputError) as caught:
        Device(machine.load(edited(tmp_path, *changes)))
    assert "my.toml" in caught.value.message
    assert sentence in caught.value.message
    assert "\n" not in caught.value.message


class Limacon(PitchCurve):
    """r = l + b cos u, whose centre distance is known in closed form (Litvin et al. 2009)."""

    name = "limacon"
    title = "deformed Pascal limacon"
    l = Quantity("l", "m", "mean radius", "test", shown="l_mm")  # noqa: E741
    b = Quantity("b", "m", "amplitude", "test", shown="b_mm")
    parameters = (l, b)

    def radius(self) -> Expr:
        return self.l + self.b * sp.cos(curves.u)

    def conditions(self) -> list[Condition]:
        return [Condition("b", self.l - self.b, "less than l")]


@pytest.fixture
def with_limacon(monkeypatch: pytest.MonkeyPatch) -> None:
    family = Limacon()
    fresh = ModuleType("curve_limacon")
    exec(emit_curve.casadi_module(family), vars(fresh))
    described: dict[str, Any] = json.loads(emit_sidecar.of_curve(family))
    module, sidecar, families = emitted.module, emitted.sidecar, emitted.families
    monkeypatch.setattr(emitted, "module", lambda name: fresh if name == "curve_limacon" else module(name))
    monkeypatch.setattr(emitted, "sidecar", lambda name: described if name == "curve_limacon" else sidecar(name))
    monkeypatch.setattr(emitted, "families", lambda: (*families(), "limacon"))
    return


@pytest.mark.usefixtures("with_limacon")
def test_a_new_family_changes_nothing_in_planter(tmp_path: Path) -> None:
    """One class makes a device: names, closure, centre distance and gradients come along."""
    path = edited(
        tmp_path,
        (r'^family = "ellipse"', 'family = "limacon"'),
        (r"^A6_mm = 30.*", "l6_mm = 30.6"), (r"^k6 = 0.*", "b6_mm = 1.0"),
        (r"^A6_mm = \[.*", "l6_mm = [30, 31]"), (r"^k6 = \[.*", "b6_mm = [0.5, 2]"),
    )  # fmt: skip
    device = Device(machine.load(path))
    assert device.names[7:] == ("l6_mm", "b6_mm", "m61")
    at = device.prologue(device.design)
    a2 = at.h[1 + device.stages[0].terms] * 1e3
    assert a2 == pytest.approx((4 * 30.6 + 2 * np.sqrt(30.6**2 + 3)) / 3, rel=1e-12)
    phi = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    assert device.support(at, phi).mean() == pytest.approx(9.975 * 9.81, abs=1e-3)


def test_a_radius_beyond_the_centre_distance_is_named_with_its_angle() -> None:
    """A stage whose prologue is told a centre distance that is too short."""
    stage = Device(machine.load("wang2017")).stages[1]
    from planter.gears import Candidate

    class Short(type(stage)):  # type: ignore[misc]
        @property
        def prologue(self) -> Any:
            return lambda parameters: {"hoisted": np.array([[0.031]])}

    short = Short(stage.family, stage.names)
    with pytest.raises(GeometryError, match=r"deformed ellipse r = .* mm at t = 0 deg is not allowed"):
        short.check_radius(Candidate(np.array([0.030694, 0.031, 1.26]), lambda name: f"my.toml: design.{name}"))
