"""What is emitted of a system in general: prologue, events and frame where there are any, names that cannot clash."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
import sympy as sp
from sympy import Expr, cos, sin

from derive import quantity as quantities
from derive.emit.folder import built_in, texts
from derive.emit.text import list_functions
from derive.model import Call, ClosedForm, Event, Lane, Let, RuntimeFunction, Shared, Step, System
from derive.quantity import OpenVector, Quantity, Vector, reserve


def quantity(name: str, unit: str = "1") -> Quantity:
    return Quantity(name, unit, f"{name} of the test", "test")


phi, size, weight, load, total = map(quantity, ("phi", "size", "weight", "load", "total"))
SIZES, WEIGHTS, SIDE = Vector("sizes", (size,)), Vector("weights", (weight,)), Vector("side", (load,))
CURVES = RuntimeFunction("rise", "cam laws", ("angle", "law"), ("lift", "slope"))
LAW = OpenVector("law", "numbers of a cam law, its end last", {-1: quantity("end")}, sized_by=("rise", "law"))


def let(symbol: Quantity, expr: Expr) -> Let:
    return Let(symbol, expr, "test")


def twin(symbol: Quantity) -> Quantity:
    return quantity(f"{symbol.name}_2")


def lane(*steps: Step, inputs: tuple[Vector | OpenVector, ...] = (SIZES, WEIGHTS), **rest: object) -> Lane:
    return Lane(phi, inputs, steps or (let(load, size * sin(phi)),), SIDE, **rest)


def emitted(of: Lane) -> dict[str, tuple[str, ...]]:
    system = System("test", "Test", "test", (), of)
    return {f.name: tuple(v.name for v in f.inputs) for f in list_functions(system)}


def module(of: Lane, target: str, tmp_path: Path) -> ModuleType:
    """The module of a lane in a target, written and imported."""
    (found,) = (t for t in built_in() if t.name == target)
    path = tmp_path / "test.py"
    path.write_text(texts([System("test", "Test", "test", (), of)], (), [found])[found.path("test")])
    spec = importlib.util.spec_from_file_location("emitted_test", path)
    assert spec is not None
    assert spec.loader is not None
    made = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(made)
    return made


def test_a_lane_that_hoists_nothing_has_no_prologue(tmp_path: Path) -> None:
    assert emitted(lane()) == {"lane": ("phi", "sizes", "weights")}
    assert module(lane(), "array", tmp_path).lane(np, 0.5, [3.0], [1.0]) == (3 * np.sin(0.5),)


def test_what_the_angle_does_not_change_is_hoisted(tmp_path: Path) -> None:
    held = quantity("held")
    found = lane(let(held, sin(size)), let(load, held * cos(phi)))
    assert emitted(found) == {"prologue": ("sizes", "weights"), "lane": ("phi", "sizes", "weights", "hoisted")}
    code = module(found, "array", tmp_path)
    hoisted = code.prologue(np, [3.0], [1.0])
    assert code.lane(np, 0.5, [3.0], [1.0], hoisted) == pytest.approx((np.sin(3) * np.cos(0.5),))


def test_what_sides_share_takes_the_inputs_that_it_needs_and_no_others(tmp_path: Path) -> None:
    shared = Shared(twin, (let(total, load + twin(load) + weight),), Vector("totals", (total,)))
    assert emitted(lane(shared=shared))["frame"] == ("side1", "side2", "weights")
    assert module(lane(shared=shared), "array", tmp_path).frame(np, [1.0], [2.0], [4.0]) == (7.0,)
    alone = Shared(twin, (let(total, load + twin(load)),), Vector("totals", (total,)))
    assert emitted(lane(shared=alone))["frame"] == ("side1", "side2")


def test_a_function_composed_at_run_time_is_an_argument(tmp_path: Path) -> None:
    lift = quantity("lift")
    steps = (Call((lift, None), CURVES, 2 * phi, (LAW,), "test"), let(load, lift * size))
    found = lane(*steps, inputs=(SIZES, LAW))
    assert "`rise` is one of cam laws, (angle, law) -> (lift, slope). Inputs:" in str(
        module(found, "casadi", tmp_path).__doc__
    )
    code = module(found, "array", tmp_path)
    assert code.lane(np, 0.5, [3.0], [0.25], lambda xp, angle, law: (angle + law[-1], 0.0)) == (3.75,)


def test_a_vector_of_open_length_that_nothing_sizes_is_refused(tmp_path: Path) -> None:
    loose = OpenVector("law", "numbers of a cam law", {-1: size})
    with pytest.raises(ValueError, match="vector law: nothing says how long it is"):
        module(lane(inputs=(loose,)), "casadi", tmp_path)


def test_events_are_numbered_and_one_that_never_comes_is_refused() -> None:
    event = Event("zero", sin(phi), sp.S.Zero, order=1)
    assert emitted(lane(events=(event,)))["events"] == ("phi", "sizes", "weights")
    with pytest.raises(ValueError, match="an event does not depend on phi"):
        emitted(lane(events=(event, Event("never", size, weight, order=1))))


def test_a_name_that_a_common_subexpression_would_take_is_left_to_its_owner(tmp_path: Path) -> None:
    c1 = quantity("c1")
    steps = (let(c1, 5 * sin(phi + size) + weight), let(load, c1 + sin(phi + size) ** 2))
    code = module(lane(*steps), "array", tmp_path)
    assert code.lane(np, 0.5, [3.0], [7.0]) == pytest.approx((5 * np.sin(3.5) + 7 + np.sin(3.5) ** 2,))


@pytest.mark.parametrize(
    ("of", "sentence"),
    [
        (lambda: lane(let(load, twin(load))), "lane: load needs load_2, which nothing gives"),
        (lambda: Lane(phi, (), (), SIDE), "lane: its outputs need load, which nothing gives"),
        (lambda: lane(events=(Event("e", total, phi, 1),)), "lane: e needs total, which nothing gives"),
        (lambda: lane(shared=Shared(twin, (), Vector("totals", (total,)))), "frame: its totals need total"),
        (lambda: ClosedForm("f", (phi,), (), Vector("v", (load,))), "f: its outputs need load"),
    ],
)
def test_what_nothing_gives_is_refused(of: object, sentence: str) -> None:
    with pytest.raises(ValueError, match=sentence):
        of()


def test_a_name_for_two_things_is_refused() -> None:
    with pytest.raises(ValueError, match="function lane: load stands for two things"):
        emitted(lane(let(load, phi), let(load, phi**2)))
    with pytest.raises(ValueError, match="function lane: size stands for two things"):
        emitted(lane(inputs=(Vector("size", (size,)),)))
    with pytest.raises(ValueError, match="function lane: side stands for two things"):
        emitted(lane(let(load, size * phi), inputs=(Vector("side", (size,)),)))
    form = ClosedForm("lane", (phi,), (let(load, phi),), SIDE)
    with pytest.raises(ValueError, match="test: two functions are called lane"):
        texts([System("test", "Test", "test", (), lane(), (form,))], (), ())


def test_a_lane_and_closed_forms_stand_in_one_module(tmp_path: Path) -> None:
    form = ClosedForm("twice", (phi,), (let(load, 2 * phi),), SIDE)
    content = texts([System("test", "Test", "test", (), lane(), (form,))], (), built_in())
    assert {"test.py", "array/test.py", "test.json"} < content.keys()
    assert "def lane(" in content["test.py"]
    assert "def twice(" in content["test.py"]


WORDS = {
    "lambda": "a word of Python", "None": "a word of Python", "sin": "generated casadi code", "SX": "generated casadi",
    "Function": "generated casadi", "fmax": "generated casadi", "if_else": "generated casadi", "xp": "generated array",
}  # fmt: skip


@pytest.mark.parametrize("name", [*WORDS, "two words", "1st"])
def test_names_that_would_break_a_module_are_refused_everywhere(name: str) -> None:
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


def test_a_name_given_before_its_target_was_known_is_refused_when_written(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(quantities, "_RESERVED", dict(quantities._RESERVED))
    early = quantity("early")
    system = System("test", "Test", "test", (), lane(let(early, phi), let(load, early**2)))
    texts([system], (), ())
    reserve("late", ["early"])
    with pytest.raises(ValueError, match=r"test\.lane: early: generated late code needs that name"):
        texts([system], (), ())
