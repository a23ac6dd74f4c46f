"""Every corner of generated functions along an angle is an event of their module: of all machines,
and at random.
"""

from __future__ import annotations

import importlib.util
import json
import math
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support import own
from tests.support.corners import Inputs, Traced, TracingNamespace, list_unmarked
from tests.support.integrands import INTEGRANDS, STATEMENT

GENERATED = Path(__file__).parents[3] / "generated"
BUILT_IN = tuple(
    path.stem
    for path in sorted((GENERATED / "array").glob("*.py"))
    if "\ndef lane(" in path.read_text("utf-8")
)
FREE = {
    "cart_pole",
    "gear_rattle",
    "pin_clearance",
    "released_device",
    "released_press",
    "released_train",
    "rotary_transplanter",
    "row_unit",
    "spinning_top",
}
"""Examples in free motion, where events are those of a state."""
DRIVEN = tuple(
    sorted(
        {*own.LIBRARY, "slider_crank", "cam_follower", "planetary_train", "transplanting_arm"}
        - FREE
    )
)


def list_periods(sidecar: Path) -> list[float | None]:
    return [event["period"] for event in json.loads(sidecar.read_text("utf-8")).get("events", [])]


def compose(gives: Sequence[str], argument: float) -> tuple[Traced, ...]:
    """Return what a composed function gives at an argument: smooth, and positive what is so by its
    meaning.
    """
    return tuple(
        Traced(2 + math.sin(k + argument), 1 if name in ("r", "ratio") else -1)
        for k, name in enumerate(gives)
    )


def build_inputs(module: ModuleType, sidecar: Path) -> Inputs:
    """Return inputs of a lane: numbers that do not change, loops that do, functions that are
    composed at run time.
    """
    described = json.loads(sidecar.read_text("utf-8"))
    names = described["functions"]["lane"]["inputs"]
    callables = described.get("callables", [])
    rng = np.random.default_rng(1)
    stage = ("r", "dr", "ddr", "ratio", "dratio", "turned")
    gives = {name: ("p", "dp", "ddp") if name == "flank" else stage for name in callables}
    functions = {
        name: (lambda xp, x, *_, names=gives[name]: compose(names, x.value)) for name in callables
    }
    data: dict[str, Any] = {
        name: [Traced(v) for v in rng.uniform(0.3, 1.7, 60)] for name in names[1:]
    } | functions
    if "prologue" in described["functions"]:
        prologue_inputs = [
            data[name]
            for name in (*described["functions"]["prologue"]["inputs"], *callables)
            if name in data
        ]
        count = module.prologue.__code__.co_argcount - 1
        data["hoisted"] = module.prologue(TracingNamespace(), *prologue_inputs[:count])

    def build(angle: float) -> list[Any]:
        loops = [Traced(math.sin(k + 1.3 * angle) + 0.1 * angle) for k in range(60)]
        vectors = [loops if name == "loops" else data[name] for name in names[1:]]
        count = module.lane.__code__.co_argcount - 2 - len(vectors)
        return [Traced(angle), *vectors, *([functions[name] for name in callables][:count])]

    return build


def find_unmarked(module: ModuleType, sidecar: Path) -> list[str]:
    return list_unmarked(
        module.lane,
        getattr(module, "events", None),
        build_inputs(module, sidecar),
        list_periods(sidecar),
    )


def find_in_folder(folder: Path, name: str) -> list[str]:
    path = folder / "array" / f"{name}.py"
    return find_unmarked(load_module(path), folder / f"{name}.json")


def load_module(path: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    if hasattr(module, "solved"):
        module.solved = solve  # type: ignore[attr-defined]
    return module


def solve(xp: object, matrix: Sequence[Sequence[Any]], right: Sequence[Any]) -> tuple[Traced, ...]:
    """Return the unknowns, and a pivot: those do not depend on the choice of the rows, which has
    corners.
    """
    numbers = np.array([[_number(entry) for entry in row] for row in matrix])
    unknowns = np.linalg.lstsq(numbers, [_number(entry) for entry in right], rcond=None)[0]
    return (*map(Traced, unknowns), Traced(1.0))


def _number(entry: Any) -> float:
    return entry.value if isinstance(entry, Traced) else float(entry)


@pytest.mark.parametrize("name", BUILT_IN)
def test_events_mark_corners_of_built_in_lanes(name: str) -> None:
    assert find_in_folder(GENERATED, name) == []


@pytest.mark.parametrize("name", DRIVEN)
def test_events_mark_corners_of_examples(name: str) -> None:
    folder = own.generated(name)
    assert find_in_folder(folder, name) == []


@pytest.mark.parametrize("name", INTEGRANDS)
def test_events_mark_corners_of_formulas(name: str) -> None:
    assert find_in_folder(own.generated(STATEMENT.format(INTEGRANDS[name].text)), "integrand") == []


@pytest.mark.parametrize("name", ["geneva_wheel", "hay_baler"])
def test_missing_event_is_told(name: str) -> None:
    """A tampered module, whose functions of events are constants one after the other; two may mark
    one place.
    """
    folder = own.generated(name)
    sidecar = folder / f"{name}.json"
    module, periods = load_module(folder / "array" / f"{name}.py"), list_periods(sidecar)
    inputs = build_inputs(module, sidecar)
    unmarked = []
    for index in range(len(periods)):

        def events(*arguments: Any, without: int = index) -> list[Any]:
            values = list(module.events(*arguments))
            values[without] = 1.0
            return values

        unmarked += list_unmarked(module.lane, events, inputs, periods)
    assert unmarked != []
    assert list_unmarked(module.lane, None, inputs, []) != []


ANGLES = st.sampled_from(["t", "2*t", "(t - s)"])
SMOOTH = st.builds("{}({})".format, st.sampled_from(["sin", "cos"]), ANGLES)
TERMS = st.recursive(
    SMOOTH,
    lambda inner: st.one_of(
        st.builds("({} + {})".format, inner, inner),
        st.builds("({} * {})".format, inner, inner),
        st.builds("Abs({} - s)".format, inner),
        st.builds("Max({}, {})".format, inner, inner),
        st.builds("Min({}, s)".format, inner),
        st.builds("sign({})".format, inner),
        st.builds("floor(3*{})".format, inner),
        st.builds("sqrt(({})**2)".format, inner),
        st.builds("sqrt(2 + ({})**2)".format, inner),
        st.builds("sqrt(({})**2 + ({})**2)".format, inner, inner),
        st.builds("Piecewise(({}, {} > s), ({}, True))".format, inner, inner, inner),
        st.builds("atan2({}, {})".format, inner, inner),
    ),
    max_leaves=3,
)


@settings(max_examples=10, deadline=None, derandomize=True)
@given(TERMS)
def test_events_mark_corners_of_random_formulas(text: str) -> None:
    assert find_in_folder(own.generated(STATEMENT.format(text)), "integrand") == []
