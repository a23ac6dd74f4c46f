"""Planting devices as the engine loads them: a machine of each file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial

from planter.engine.machine import Machine
from planter.files import examples
from planter.planting import file
from planter.planting.composition import build_machine
from planter.planting.functions import Model
from planter.planting.model import Device
from planter.planting.requirements.constraints import Required
from planter.planting.swept import KIND, OWN

__all__ = ["build_machine", "load", "takes"]


def takes(source: str) -> bool:
    """Return whether a source is a planting device's file, or the name of a built-in one."""
    return examples.belongs(source, KIND, OWN)


def load(source: str, changes: Mapping[str, float], model: Model = "exact") -> Machine:
    """Return the machine of a planting device; raises InputError and GeometryError as its file and device do."""
    return _build_with_requirements(model, file.load(source, changes))


def _build_with_requirements(model: Model, machine: file.Machine) -> Machine:
    device = Device(machine, model)
    built = build_machine(device)
    if machine.requirements is None:
        return built
    return replace(built, build=partial(_build_with_requirements, model), requirements=partial(Required, device))
