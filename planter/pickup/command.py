"""What `planter pickup` does: load, build, move if asked to, tell."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from planter.errors import InputError
from planter.optimise.result import Certificate
from planter.pickup.file import Pickup, load
from planter.pickup.findings import found
from planter.pickup.model import Train, build
from planter.pickup.redesign import Redesign, redesign
from planter.pickup.results import Held, Optimised, PickupFound, Proof
from planter.progress import Listener


@dataclass(frozen=True)
class Outcome:
    """A pick-up, its train, the redesign if there was one, and what the command returns."""

    machine: Pickup
    train: Train
    redesigned: Redesign | None
    result: PickupFound


def run(
    source: str,
    at: Sequence[float] = (),
    optimise: bool = False,
    changes: Mapping[str, float] | None = None,
    progress: Listener | None = None,
) -> Outcome:
    """The outcome for a file, built-in name or CSV of points; `at` are carrier angles [deg] from the farthest tip.

    Raises InputError for bad input, ComputationError where nothing was found.
    """
    for angle in at:
        if not math.isfinite(angle):
            raise InputError(f"--at {angle} is not allowed: it must be a finite angle in deg")
    machine = load(source, changes)
    train = build(machine)
    if not optimise:
        return Outcome(machine, train, None, found(machine, train, at))
    moved = redesign(machine, train, progress)
    return Outcome(machine, moved.train, moved, replace(found(machine, moved.train, at), optimised=_told(moved)))


def _told(moved: Redesign) -> Optimised:
    return Optimised(
        holds=moved.holds,
        moved_mm=moved.moved * 1000,
        iterations=moved.iterations,
        rounds=moved.rounds,
        certificate=None if moved.certificate is None else _certificate(moved.certificate),
        requirements_before=[requirement.shown() for requirement in moved.before],
        value_points_before_mm=[(x, y) for x, y in (moved.points_before * 1000).tolist()],
        value_points_mm=[(x, y) for x, y in (moved.points * 1000).tolist()],
    )


def _certificate(proof: Certificate) -> Proof:
    """Residual of the last round's optimum, and the requirements that hold it.

    A multiplier is what the change gains per unit of its requirement.
    """
    return Proof(proof.kkt_residual, [Held(**vars(one)) for one in proof.active_constraints])
