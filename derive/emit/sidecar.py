"""What a generated module holds, as JSON: names, units, meanings, sources, joints, operation counts."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import sympy as sp

from ..gearing.pitch_curve import PitchCurve, length_parameters, scale_invariants
from ..mechanics.turning import DrivenLane
from ..model import Event, Lane, System
from ..quantity import OpenVector, Quantity, Vector
from .curve import all_conditions, parameters_of
from .schedule import COMMON
from .text import Emitted


def of_system(system: System, functions: Sequence[Emitted]) -> str:
    """The sidecar of a model; names of composed functions and joints only where there are any."""
    events = system.lane.events if system.lane else ()
    return _json({
        "name": system.name,
        "title": system.title,
        "source": system.source,
        "assumptions": system.assumptions,
        **({"callables": [f.name for f in system.functions]} if system.functions else {}),
        **({"speed": system.lane.speed.name} if system.lane and system.lane.speed else {}),
        **_acceleration(system.lane),
        "vectors": {v.name: _vector(v) for v in system.vectors},
        **({"events": [_event(e) for e in events]} if events else {}),
        **({"effects": {"without": system.effects.without, "felt": system.effects.felt}} if system.effects else {}),
        **({"pushing": system.pushing} if system.pushing else {}),
        **({"axes": system.axes} if system.axes else {}),
        **({"meshes": system.meshes} if system.meshes else {}),
        "functions": {f.name: _function(f) for f in functions},
        "equations": sorted({s.source for f in functions for s in f.steps} - {COMMON}),
    })  # fmt: skip


def _acceleration(lane: Lane | None) -> dict[str, str]:
    acceleration = lane.acceleration if isinstance(lane, DrivenLane) else None
    return {} if acceleration is None else {"acceleration": acceleration.name}


def of_curve(curve: PitchCurve, functions: Sequence[Emitted]) -> str:
    return _json({
        "name": curve.name,
        "title": curve.title,
        "source": "pitch curve and conjugate derived from its radius",
        "radius": str(curve.radius()),
        "parameters": _vector(parameters_of(curve)),
        "series": not isinstance(curve.turned(), sp.Expr),
        "similar": {
            "lengths": [q.name for q in length_parameters(curve)],
            "unchanged": [q.name for q in scale_invariants(curve)],
        },
        "conditions": [{"name": c.name, "allowed": c.allowed} for c in all_conditions(curve)],
        "shapes": [_entry(s.quantity) | {"lower": float(s.lower), "upper": float(s.upper)} for s in curve.shapes],
        "functions": {f.name: _function(f) for f in functions},
    })  # fmt: skip


def _event(event: Event) -> dict[str, Any]:
    entry = {"name": event.name, "order": event.order, "period": float(event.period) if event.period else None}
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
