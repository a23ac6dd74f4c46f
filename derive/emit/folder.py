"""Files of a generated folder: models and pitch curves in every target, sidecars, machine files."""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import Any

import sympy as sp

from ..discovery import import_modules, list_offers
from ..mechanics.driven_motion import DrivenLane
from ..mechanics.gearing.pitch_curve import PitchCurve, length_parameters, scale_invariants
from ..model import COMMON, Event, System
from ..quantity import OpenVector, Quantity, Vector, refuse_name, reserve
from . import targets
from .text import Emitted, build_curve_functions, list_conditions, list_functions, pack_parameters


@dataclass(frozen=True)
class Target:
    """A language: the place of its files, such as ``array/{name}.py``, and the texts of a model and
    of a pitch curve.

    ``reserved`` are names that the texts need for themselves, so that no quantity can have them. A
    target ``on_request`` is written, with its names unchanged, only on request.
    """

    name: str
    place: str
    reserved: frozenset[str]
    model: Callable[[System, Sequence[Emitted]], str]
    curve: Callable[[PitchCurve, Sequence[Emitted]], str]
    on_request: bool = False

    def __post_init__(self) -> None:
        if not self.on_request:
            self.reserve()

    def reserve(self) -> None:
        """Keep its names from quantities."""
        reserve(self.name, self.reserved)

    def path(self, name: str) -> str:
        """Return the path of the file of a model or a curve inside the generated folder."""
        return self.place.format(name=name)


def built_in() -> list[Target]:
    """The languages whose files stand in ``targets``."""
    return list_offers(import_modules(targets), "TARGET")


def select_targets(targets: Iterable[Target], names: Collection[str] = ()) -> list[Target]:
    """The languages that are always written, and those that are asked for by name, whose names are
    reserved from now on.

    Raises ValueError where none has a name that is asked for.
    """
    by_name = {target.name: target for target in targets}
    if unknown := sorted(set(names) - by_name.keys()):
        raise ValueError(
            f"no target is called {unknown[0]}; there are {', '.join(sorted(by_name))}"
        )
    selected = [
        target for target in by_name.values() if target.name in names or not target.on_request
    ]
    for target in selected:
        target.reserve()
    return selected


DATA = "data"
"""The packed input that holds what the statement gives values of."""


def format_machine_file(system: System) -> dict[str, str]:
    """`NAME.toml` of a model whose statement gives values; nothing of any other."""
    return {f"{system.name}.toml": _text(system)} if system.data else {}


def _text(system: System) -> str:
    data = next(v.quantities for v in system.vectors if isinstance(v, Vector) and v.name == DATA)
    bounds = {
        q: system.data[q.name].bounds
        for q in data
        if q.name in system.data and system.data[q.name].bounds
    }
    lines = [
        f"# Values of {system.title}, as its statement gives them; copy this file to change them.",
        "",
        f"name = {json.dumps(system.name)}",
        f"description = {json.dumps(system.title, ensure_ascii=False)}",
        f"functions = {json.dumps(system.name)}",
        "",
        "[values]",
        *(_value(q, system) for q in data),
    ]
    if bounds:
        lines += [
            "",
            "[bounds]",
            *(f"{_key(q)} = [{pair[0]}, {pair[1]}]" for q, pair in bounds.items() if pair),
        ]
    span = ("[turn]", "samples = 360") if system.lane else ("[motion]", "until_s = 2")
    return "\n".join((*lines, "", *span, "", "[origin]", 'default = "assumed"', ""))


def _value(quantity: Quantity, system: System) -> str:
    datum, note = system.data.get(quantity.name), f"# {quantity.meaning}"
    return (
        f"{_key(quantity)} = {datum.value}  {note}"
        if datum
        else f"# {_key(quantity)} =  {note}; not given"
    )


def _key(quantity: Quantity) -> str:
    return quantity.shown.rpartition(".")[2]


def build_sidecar(system: System, functions: Sequence[Emitted]) -> str:
    """The sidecar of a model; what not every model has stands in it only where there is any."""
    lane, effects = system.lane, system.effects
    speed = lane.speed if lane else None
    acceleration = lane.acceleration if isinstance(lane, DrivenLane) else None
    content = {
        "name": system.name,
        "title": system.title,
        "source": system.source,
        "assumptions": system.assumptions,
        "callables": [f.name for f in system.functions],
        "speed": speed and speed.name,
        "acceleration": acceleration and acceleration.name,
        "vectors": {v.name: _vector(v) for v in system.vectors},
        "events": [_event(event) for event in lane.events] if lane else [],
        "effects": effects and {"without": effects.without, "felt": effects.felt},
        "pushing": system.pushing,
        "axes": system.axes,
        "meshes": system.meshes,
        "supports": system.supports,
        "loads": system.loads,
        "drawn": system.elements,
        "inputs": _list_inputs(system),
        "begun": system.begun,
        "held": system.held_entries,
        "added_inertia": system.added_inertia,
        "functions": {f.name: _function(f) for f in functions},
        "equations": sorted({s.source for f in functions for s in f.steps} - {COMMON}),
    }
    always = ("assumptions", "vectors", "functions", "equations")
    is_held = system.held_entries is not None
    return _json(
        {
            key: value
            for key, value in content.items()
            if value or key in always or (key == "held" and is_held)
        }
    )


def _list_inputs(system: System) -> list[dict[str, str | float]]:
    inputs = list[dict[str, str | float]]()
    for name, ends in system.open_inputs.items():
        bounds = zip(("low", "high"), ends, strict=True)
        stated = {key: end for key, end in bounds if end is not None}
        inputs.append({"name": name, **stated})
    return inputs


def build_curve_sidecar(curve: PitchCurve, functions: Sequence[Emitted]) -> str:
    """Build the JSON description of a family of pitch curves and of the functions that are
    generated for it.
    """
    return _json(
        {
            "name": curve.name,
            "title": curve.title,
            "source": "pitch curve and conjugate derived from its radius",
            "radius": str(curve.radius()),
            "parameters": _vector(pack_parameters(curve)),
            "series": not isinstance(curve.turned(), sp.Expr),
            "similar": {
                "lengths": [q.name for q in length_parameters(curve)],
                "unchanged": [q.name for q in scale_invariants(curve)],
            },
            "conditions": [{"name": c.name, "allowed": c.allowed} for c in list_conditions(curve)],
            "shapes": [
                _entry(s.quantity) | {"lower": float(s.lower), "upper": float(s.upper)}
                for s in curve.shapes
            ],
            "functions": {f.name: _function(f) for f in functions},
        }
    )


def _event(event: Event) -> dict[str, Any]:
    entry = {
        "name": event.name,
        "order": event.order,
        "period": float(event.period) if event.period else None,
    }
    return entry if event.position is None else entry | {"position": float(event.position)}


def _function(function: Emitted) -> dict[str, Any]:
    return {
        "inputs": [v.name for v in function.inputs],
        "output": function.output.name,
        "operations": function.operations,
    }


def _vector(vector: Vector | OpenVector) -> Any:
    if isinstance(vector, OpenVector):
        return {
            "meaning": vector.meaning,
            "suffix": vector.suffix,
            "known": {str(i): _entry(s) for i, s in vector.known.items()},
        }
    return [_entry(s) for s in vector]


def _entry(quantity: Quantity) -> dict[str, str]:
    entry = {
        "name": quantity.name,
        "unit": quantity.unit,
        "meaning": quantity.meaning,
        "source": quantity.source,
    }
    return entry | ({"shown": quantity.shown} if quantity.shown else {})


def _json(content: dict[str, Any]) -> str:
    return json.dumps(content, indent=1, ensure_ascii=False) + "\n"


HEAD = '"""Generated by `python -m derive`; do not edit."""\n'


def render_texts(
    systems: Iterable[System], families: Iterable[PitchCurve], targets: Sequence[Target]
) -> dict[str, str]:
    """Path inside the folder -> content.

    Raises ValueError where a name cannot stand in what is generated.
    """
    texts_by_path = {"__init__.py": HEAD}
    for new in (
        *(emit_curve(f, targets) for f in families),
        *(emit_system(s, targets) for s in systems),
    ):
        if twice := sorted(texts_by_path.keys() & new.keys()):
            raise ValueError(f"two models or families are called {PurePosixPath(twice[0]).stem}")
        texts_by_path |= new
    packages = {PurePosixPath(path).parent for path in texts_by_path if path.endswith(".py")} - {
        PurePosixPath(".")
    }
    return texts_by_path | {f"{package}/__init__.py": "" for package in packages}


def emit_curve(family: PitchCurve, targets: Sequence[Target]) -> dict[str, str]:
    """The files of a family of pitch curves."""
    name, emitted = f"curve_{family.name}", tuple(build_curve_functions(family))
    _refuse_names(name, emitted)
    return {t.path(name): t.curve(family, emitted) for t in targets} | {
        f"{name}.json": build_curve_sidecar(family, emitted)
    }


def emit_system(system: System, targets: Sequence[Target]) -> dict[str, str]:
    """The files of a model."""
    emitted = list_functions(system)
    _refuse_names(system.name, emitted)
    return {t.path(system.name): t.model(system, emitted) for t in targets} | {
        f"{system.name}.json": build_sidecar(system, emitted),
        **format_machine_file(system),
    }


def _refuse_names(module: str, emitted: Sequence[Emitted]) -> None:
    """Names are refused where they are given; those given before a target was known are refused
    here.
    """
    refuse_name("module", module)
    names = [function.name for function in emitted]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise ValueError(f"{module}: two functions are called {twice[0]}")
    for function in emitted:
        for name in (function.name, *function.speaks):
            refuse_name(f"{module}.{function.name}:", name)
