"""What is emitted of a system in general: prologue, events and frame where there are any, names
that cannot clash.
"""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
import sympy as sp
from sympy import Expr, cos, sin

from derive.emit.folder import built_in, render_texts
from derive.emit.text import list_functions
from derive.model import Call, ClosedForm, Event, Lane, Let, RuntimeFunction, Shared, Step, System
from derive.quantity import OpenVector, Quantity, Vector


def quantity(name: str, unit: str = "1") -> Quantity:
    return Quantity(name, unit, f"{name} of the test", "test")


phi, size, weight, load, total = map(quantity, ("phi", "size", "weight", "load", "total"))
SIZES, WEIGHTS, SIDE = (
    Vector("sizes", (size,)),
    Vector("weights", (weight,)),
    Vector("side", (load,)),
)
CURVES = RuntimeFunction("rise", "cam laws", ("angle", "law"), ("lift", "slope"))
LAW = OpenVector(
    "law", "numbers of a cam law, its end last", {-1: quantity("end")}, sized_by=("rise", "law")
)


def let(symbol: Quantity, expr: Expr) -> Let:
    return Let(symbol, expr, "test")


def twin(symbol: Quantity) -> Quantity:
    return quantity(f"{symbol.name}_2")


def lane(
    *steps: Step, inputs: tuple[Vector | OpenVector, ...] = (SIZES, WEIGHTS), **rest: object
) -> Lane:
    return Lane(phi, inputs, steps or (let(load, size * sin(phi)),), SIDE, **rest)


def emitted(source: Lane) -> dict[str, tuple[str, ...]]:
    system = System("test", "Test", "test", (), source)
    return {f.name: tuple(v.name for v in f.inputs) for f in list_functions(system)}


def module(source: Lane, target: str, tmp_path: Path) -> ModuleType:
    """The module of a lane in a target, written and imported."""
    (writer,) = (t for t in built_in() if t.name == target)
    path = tmp_path / "test.py"
    path.write_text(
        render_texts([System("test", "Test", "test", (), source)], (), [writer])[
            writer.path("test")
        ]
    )
    spec = importlib.util.spec_from_file_location("emitted_test", path)
    assert spec is not None
    assert spec.loader is not None
    new_module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(new_module)
    return new_module


def test_lane_without_invariants_has_no_prologue(tmp_path: Path) -> None:
    assert emitted(lane()) == {"lane": ("phi", "sizes", "weights")}
    assert module(lane(), "array", tmp_path).lane(np, 0.5, [3.0], [1.0]) == (3 * np.sin(0.5),)


def test_angle_invariants_go_to_the_prologue(tmp_path: Path) -> None:
    constant = quantity("held")
    system = lane(let(constant, sin(size)), let(load, constant * cos(phi)))
    assert emitted(system) == {
        "prologue": ("sizes", "weights"),
        "lane": ("phi", "sizes", "weights", "hoisted"),
    }
    code = module(system, "array", tmp_path)
    hoisted = code.prologue(np, [3.0], [1.0])
    assert code.lane(np, 0.5, [3.0], [1.0], hoisted) == pytest.approx((np.sin(3) * np.cos(0.5),))


def test_shared_part_takes_only_needed_inputs(tmp_path: Path) -> None:
    shared = Shared(twin, (let(total, load + twin(load) + weight),), Vector("totals", (total,)))
    assert emitted(lane(shared=shared))["frame"] == ("side1", "side2", "weights")
    assert module(lane(shared=shared), "array", tmp_path).frame(np, [1.0], [2.0], [4.0]) == (7.0,)
    alone = Shared(twin, (let(total, load + twin(load)),), Vector("totals", (total,)))
    assert emitted(lane(shared=alone))["frame"] == ("side1", "side2")


def test_a_function_composed_at_run_time_is_an_argument(tmp_path: Path) -> None:
    lift = quantity("lift")
    steps = (Call((lift, None), CURVES, 2 * phi, (LAW,), "test"), let(load, lift * size))
    system = lane(*steps, inputs=(SIZES, LAW))
    assert "`rise` is one of cam laws, (angle, law) -> (lift, slope). Inputs:" in str(
        module(system, "casadi", tmp_path).__doc__
    )
    code = module(system, "array", tmp_path)
    assert code.lane(np, 0.5, [3.0], [0.25], lambda xp, angle, law: (angle + law[-1], 0.0)) == (
        3.75,
    )


def test_open_vector_without_size_is_refused(tmp_path: Path) -> None:
    loose = OpenVector("law", "numbers of a cam law", {-1: size})
    with pytest.raises(ValueError, match="vector law: nothing says how long it is"):
        module(lane(inputs=(loose,)), "casadi", tmp_path)


def test_impossible_event_is_refused() -> None:
    event = Event("zero", sin(phi), sp.S.Zero, order=1)
    assert emitted(lane(events=(event,)))["events"] == ("phi", "sizes", "weights")
    with pytest.raises(ValueError, match="an event does not depend on phi"):
        emitted(lane(events=(event, Event("never", size, weight, order=1))))


def test_subexpressions_avoid_existing_names(tmp_path: Path) -> None:
    c1 = quantity("c1")
    steps = (let(c1, 5 * sin(phi + size) + weight), let(load, c1 + sin(phi + size) ** 2))
    code = module(lane(*steps), "array", tmp_path)
    assert code.lane(np, 0.5, [3.0], [7.0]) == pytest.approx(
        (5 * np.sin(3.5) + 7 + np.sin(3.5) ** 2,)
    )


@pytest.mark.parametrize(
    ("source", "sentence"),
    [
        (lambda: lane(let(load, twin(load))), "lane: load needs load_2, which nothing gives"),
        (lambda: Lane(phi, (), (), SIDE), "lane: its outputs need load, which nothing gives"),
        (
            lambda: lane(events=(Event("e", total, phi, 1),)),
            "lane: e needs total, which nothing gives",
        ),
        (
            lambda: lane(shared=Shared(twin, (), Vector("totals", (total,)))),
            "frame: its totals need total",
        ),
        (lambda: ClosedForm("f", (phi,), (), Vector("v", (load,))), "f: its outputs need load"),
    ],
)
def test_missing_input_is_refused(source: object, sentence: str) -> None:
    with pytest.raises(ValueError, match=sentence):
        source()


def test_a_name_for_two_things_is_refused() -> None:
    with pytest.raises(ValueError, match="function lane: load stands for two things"):
        emitted(lane(let(load, phi), let(load, phi**2)))
    with pytest.raises(ValueError, match="function lane: size stands for two things"):
        emitted(lane(inputs=(Vector("size", (size,)),)))
    with pytest.raises(ValueError, match="function lane: side stands for two things"):
        emitted(lane(let(load, size * phi), inputs=(Vector("side", (size,)),)))
    form = ClosedForm("lane", (phi,), (let(load, phi),), SIDE)
    with pytest.raises(ValueError, match="test: two functions are called lane"):
        render_texts([System("test", "Test", "test", (), lane(), (form,))], (), ())


def test_module_holds_lane_and_closed_forms(tmp_path: Path) -> None:
    form = ClosedForm("twice", (phi,), (let(load, 2 * phi),), SIDE)
    content = render_texts([System("test", "Test", "test", (), lane(), (form,))], (), built_in())
    assert {"test.py", "array/test.py", "test.json"} < content.keys()
    assert "def lane(" in content["test.py"]
    assert "def twice(" in content["test.py"]


WORDS = {
    "lambda": "a word of Python",
    "None": "a word of Python",
    "sin": "generated casadi code",
    "SX": "generated casadi",
    "Function": "generated casadi",
    "fmax": "generated casadi",
    "if_else": "generated casadi",
    "xp": "generated array",
}


@pytest.mark.parametrize("name", [*WORDS, "two words", "1st"])
def test_names_breaking_a_module_are_refused(name: str) -> None:
    """Each with an underscore is taken."""
    built_in()
    sentence = WORDS.get(name, "must be a Python identifier")
    for make in (
        quantity,
        lambda n: Vector(n, ()),
        lambda n: OpenVector(n, "test", {}),
    ):
        with pytest.raises(ValueError, match=sentence):
            make(name)
        if name in WORDS:
            make(f"{name}_")
    with pytest.raises(ValueError, match=sentence):
        ClosedForm(name, (), (), Vector("none", ()))
