"""`planter calibrate` without data: unpublished inputs that a search found for figures of a paper.

`docs/studies/wang2017.md` has the search and writes its record, whose inputs are evaluated here.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from typing import Any

import numpy as np

from planter import paths
from planter.errors import InputError
from planter.files import units
from planter.papers.planting.file import PlantingMachine, load
from planter.papers.planting.functions import MODELS, Model
from planter.papers.planting.model import Device
from planter.papers.planting.results import (
    CalibrationFound,
    CalibrationTradeoff,
    Fitted,
    OtherModel,
    Statistics,
)

SEARCHED = "wang2017"
"""The machine that inputs were searched for."""
MET = 0.01
"""A target is met where none of its figures is missed by more than this share."""


@cache
def load_study() -> dict[str, Any]:
    """Return the targets with the fits of each model, and the optimum of the printed equations."""
    file = files("planter.papers.planting.printed").joinpath("study.json")
    study: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
    return study


def calibrate(machine: PlantingMachine, model: Model, target: str = "table1") -> CalibrationFound:
    """Return the inputs with which a model comes nearest to figures of the machine's paper.

    Raises InputError for an unknown target, and for a machine whose inputs were not searched for.
    """
    targets = load_study()["targets"]
    if target not in targets:
        raise InputError.for_value("--target", target, paths.suggest_names(target, targets))
    if machine.table() != load(SEARCHED).table():
        raise InputError(
            f"{machine.source}: inputs for {target} were searched for {SEARCHED} alone: fit a "
            f"measured curve by --data, or search as docs/studies/wang2017.md does"
        )
    figures: dict[str, float] = targets[target]["figures"]
    fit = targets[target]["fits"][model]
    table = machine.table()
    cam = {**table["cam"], "flank": fit["flank"]}
    changed = PlantingMachine.read({**table, "cam": cam}, machine.source)
    columns = {}
    for each in MODELS:
        device = Device(changed.with_numbers(fit["inputs"]), each)
        columns[each] = device.columns(device.design, device.engine.list_angles())
    force = Statistics.of_samples(columns[model]["support_N"]).table()
    reached = {key: force[key] for key in figures}
    misses = _measure_misses(reached, figures)
    is_met = max(map(abs, misses.values())) <= 100 * MET
    (other,) = (Statistics.of_samples(columns[m]["support_N"]) for m in MODELS if m != model)
    push = float(np.min(columns[model]["F_E_N"]))
    return CalibrationFound(
        machine=machine.name,
        model=model,
        met=is_met,
        statement=_state_result(target, model, misses, push),
        choices={"cam.flank": fit["flank"]},
        fitted=[
            Fitted(
                path, value, units.display_unit(path) or "1", *fit["bounds"].get(path, [value] * 2)
            )
            for path, value in fit["inputs"].items()
        ],
        target=figures,
        reached=reached,
        miss_percent=misses,
        least_push_N=push,
        rank=fit["rank"],
        other_model=OtherModel(other.range_N, other.variance_N2, other.mean_N),
        front=None if is_met else [_read_tradeoff(point, figures) for point in fit["front"]],
    )


def _measure_misses(reached: Mapping[str, float], figures: Mapping[str, float]) -> dict[str, float]:
    return {key: 100 * (reached[key] / value - 1) for key, value in figures.items()}


def _read_tradeoff(point: Mapping[str, Any], figures: Mapping[str, float]) -> CalibrationTradeoff:
    reached = {key: point[key] for key in figures}
    misses = _measure_misses(reached, figures)
    return CalibrationTradeoff({"cam.flank": point["flank"]}, reached, point["range_N"], misses)


def _state_result(target: str, model: Model, misses: Mapping[str, float], push: float) -> str:
    contact = "a cam that only pushes" if push >= 0 else "a cam that would have to pull"
    missed = [f"{key} by {miss:+.1f} %" for key, miss in misses.items() if abs(miss) > 100 * MET]
    if not missed:
        return (
            f"The target {target} is met by the {model} model, every number of it within "
            f"{100 * MET:g} %, with {contact}."
        )
    return (
        f"The target {target} is missed by the {model} model: {', '.join(missed)}, with {contact}. "
        f"No values within the bounds that were tried come nearer."
    )
