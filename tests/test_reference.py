"""The reference of statements: every public member on its page, with its units, and examples that
run.
"""

from __future__ import annotations

import doctest
import inspect
import re
import sys
from collections.abc import Iterator
from pkgutil import resolve_name

import numpy as np
import pytest

import derive
import planter
from planter.mechanism.dynamics import Dynamics
from planter.mechanism.file import load
from planter.mechanism.model import Model
from tests.support import own
from tests.support.structure import ROOT

sys.path.insert(0, str(ROOT / "docs"))

from book import docstrings, reference

UNIT = re.compile(r"\[[^\]]+\]|\bunits?\b|\bSI\b")
QUANTITATIVE = re.compile(r"\b(float|Array|Expr|Scalar|Quantity|Vec|Quantities|Values)\b")
CLASSES = (derive.Mechanism, derive.Formulas, derive.Paper, derive.Motion, Model, Dynamics)


def members(cls: type) -> dict[str, object]:
    """Return the public methods and properties of a class, inherited ones included."""
    attributes = {
        name: inspect.getattr_static(cls, name) for name in dir(cls) if not name.startswith("_")
    }
    return {
        name: item
        for name, item in attributes.items()
        if callable(item) or (hasattr(item, "__doc__") and item)
    }


def code(member: object) -> object:
    return getattr(member, "fget", None) or getattr(member, "func", None) or member


def complaint(member: object) -> str:
    """Return what the docstring of a method or property lacks; empty if it is complete."""
    text = inspect.getdoc(member) or ""
    if not text:
        return "no docstring"
    annotations = " ".join(map(str, getattr(code(member), "__annotations__", {}).values()))
    return "no unit" if QUANTITATIVE.search(annotations) and not UNIT.search(text) else ""


def listed_members() -> Iterator[tuple[str, object]]:
    for cls in CLASSES:
        for name, member in members(cls).items():
            if cls is not derive.Mechanism or name not in reference.UNLISTED:
                yield f"{cls.__name__}.{name}", member
    for page in reference.PAGES:
        entries = ((name, resolve_name(name)) for name in reference.names(page))
        yield from (
            (name, item)
            for name, item in entries
            if inspect.isclass(item) or inspect.isfunction(item)
        )
    for name in sorted(set(planter.__all__) - {"__version__"}):
        item = getattr(planter, name)
        yield f"planter.{name}", item
        if inspect.isclass(item) and not issubclass(item, Exception):
            own_members = members(item).items()
            yield from (
                (f"planter.{name}.{key}", value) for key, value in own_members if key in vars(item)
            )


@pytest.mark.parametrize(
    "member", [pytest.param(member, id=name) for name, member in listed_members()]
)
def test_members_have_docstrings_with_units(member: object) -> None:
    assert not complaint(member)


def test_missing_unit_is_noticed() -> None:
    def push(force: derive.Vec) -> None:
        """Apply a force to a body."""

    assert complaint(push) == "no unit"
    push.__doc__ = "Apply a force [N] to a body."
    assert not complaint(push)
    push.__doc__ = ""
    assert complaint(push) == "no docstring"


@pytest.mark.parametrize("cls", reference.SPLIT)
def test_every_member_has_a_single_entry(cls: type) -> None:
    entries = [name for page in reference.PAGES for name in reference.names(page)]
    assert len(entries) == len(set(entries))
    prefix = f"derive.{cls.__name__}."
    documented = {entry.removeprefix(prefix) for entry in entries if entry.startswith(prefix)}
    fields = set(getattr(cls, "__dataclass_fields__", ()))
    unlisted = reference.UNLISTED if cls is derive.Mechanism else set()
    assert not documented & unlisted
    assert documented | unlisted == members(cls).keys() - fields


def test_examples_use_no_unlisted_member() -> None:
    text = "".join(
        path.read_text(encoding="utf-8") for path in (ROOT / "docs" / "examples").glob("*.py")
    )
    assert {name for name in reference.UNLISTED if re.search(rf"\bm\.{name}\b", text)} == set()


def test_reference_lines_name_each_kind() -> None:
    assert list(reference.directive("derive.Mechanism.pin")) == [
        ".. automethod:: derive.Mechanism.pin",
        "",
    ]
    assert next(reference.directive("derive.Mechanism.bodies")).startswith(".. autoproperty::")
    assert "   :members:" in reference.directive("planter.mechanism.model.Model")


def test_docstring_output_stays_as_printed() -> None:
    lines = [
        ">>> for x in (1, 2):",
        "...     print(x * '_a_')",
        "_a_",
        "_a__a_",
        "",
        "Then a_ follows.",
    ]
    docstrings.as_restructured_text(None, "", "", None, None, lines)  # type: ignore[arg-type]
    assert lines[2:4] == ["_a_", "_a__a_"]
    assert lines[5] == "Then a\\_ follows."


def test_docstring_code_stays_as_written() -> None:
    lines = ["A file:", "", "    a_ = 1", "    b = '|x|'", "", ">>> 1", "1"]
    docstrings.as_restructured_text(None, "", "", None, None, lines)  # type: ignore[arg-type]
    assert lines == ["A file:", "", "::", "", "    a_ = 1", "    b = '|x|'", "", ">>> 1", "1"]


def test_example_of_dynamics_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    text = inspect.getdoc(Dynamics) or ""
    statement = "".join(re.findall(r"^    (.*\n)", text, re.MULTILINE))
    monkeypatch.chdir(own.generated(statement))
    example = doctest.DocTestParser().get_doctest(
        text.replace("# doctest: +SKIP", ""),
        {"np": np, "Dynamics": Dynamics},
        "Dynamics",
        None,
        None,
    )
    assert len(example.examples) > 4
    assert doctest.DocTestRunner().run(example).failed == 0


def test_pin_force_carries_hanging_weight() -> None:
    text = inspect.getdoc(Dynamics) or ""
    pendulum = Dynamics(
        load(
            own.generated("".join(re.findall(r"^    (.*\n)", text, re.MULTILINE))) / "pendulum.toml"
        )
    )
    hanging = pendulum.run(np.array([0.0, 0.01]), state=np.array([-np.pi / 2, 0.0]))
    assert hanging.results["F_Ay"][0] == pytest.approx(9.81)
    level = pendulum.run(np.array([0.0, 0.01]), state=np.zeros(2))
    assert level.results["F_Ay"][0] == pytest.approx(0.0, abs=1e-12)  # it falls freely
