"""Machines whose quantities are a graph over the drive's angle, without loops to be solved."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import casadi as ca
import numpy as np

from planter.engine.machine import Documentation, Machine, Quantity, Value, build_vectors
from planter.engine.measures import Limit
from planter.files import units
from planter.files.document import Document
from planter.kernels import Array

Event = tuple[ca.SX, Mapping[str, Any]]
"""A value whose zeros are kinks, and what kind they are."""


def build_closed_machine(
    document: Document,
    build: Callable[[Any], Machine],
    sidecar: Mapping[str, Any],
    values: Sequence[Value],
    data: Array,
    quantities: Mapping[str, tuple[str, str]],
    results: Mapping[str, ca.SX],
    symbols: tuple[ca.SX, ca.SX, ca.SX],
    prologue: ca.SX | ca.Function,
    events: Sequence[Event],
    speed: str,
    limits: tuple[Limit, ...],
    vectors: Mapping[str, tuple[str, str]] | None = None,
    **options: Any,
) -> Machine:
    """Return a machine from its quantities' units and meanings, and their graphs by name.

    `symbols` are the drive's angle, the values and what `prologue` finds of these; `speed` is the
    path of the drive's speed.
    """
    inputs, names = [*symbols, ca.SX.sym("q", 0)], ["phi", "d", "h", "q"]
    if isinstance(prologue, ca.SX):
        prologue = ca.Function("prologue", [symbols[1]], [prologue], ["d"], ["h"])
    listed = tuple(
        Quantity(name, *entry, units.display_key(name, entry[0]))
        for name, entry in quantities.items()
    )

    def compose(name: str, outputs: list[ca.SX]) -> ca.Function:
        return ca.Function(name, inputs, [ca.densify(ca.vertcat(*outputs))], names, ["y"])

    return Machine(
        document=document,
        build=build,
        assumptions=tuple(sidecar["assumptions"]),
        values=tuple(values),
        data=data,
        moved=(),
        lower=np.empty(0),
        upper=np.empty(0),
        quantities=listed,
        prologue=prologue,
        lane=compose("lane", [results[name] for name in quantities]),
        speed=[value.path for value in values].index(speed),
        events=compose("events", [event for event, _ in events]) if events else None,
        event_kinds=tuple(kind for _, kind in events),
        vectors=tuple(build_vectors(vectors or {}, listed)),
        limits=limits,
        documentation=Documentation(sidecar["title"], sidecar["source"]),
        **options,
    )
