"""Two pitch curves that roll on each other: of a stage, of circles, of any contact that a polar angle tells."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from planter.gearing.stage import Stage
from planter.gearing.teeth.curve import PitchCurve
from planter.gearing.teeth.rack import RACK
from planter.kernels import Array
from planter.numerics.angles import TURN

Contact = Callable[[Array], Array]
"""Radius, its two derivatives, ratio, its derivative, and the mate's rotation (6, n) at polar angles (n,) of a gear."""


@dataclass(frozen=True)
class Pair:
    """A gear's pitch curve and its mate's, the distance of their axes [m], and the sense of the gear's polar angle.

    At rolling length s the gear touches at sense * s of its own arc length, the mate at -sense * s.
    """

    gear: PitchCurve
    mate: PitchCurve
    distance: float
    sense: int = 1

    @property
    def curves(self) -> tuple[PitchCurve, PitchCurve]:
        return self.gear, self.mate

    @property
    def senses(self) -> tuple[int, int]:
        """Of both curves' own arc length against the rolling length."""
        return self.sense, -self.sense

    def scaled(self, factor: float) -> Pair:
        """The same pair with all lengths multiplied."""
        return Pair(self.gear.scaled(factor), self.mate.scaled(factor), self.distance * factor, self.sense)


def of_contact(contact: Contact, distance: float, breaks: Array, sense: int = 1, turns: int = 1) -> Pair:
    """The pair of a contact that is smooth between breaks (m,) over a turn, whose mate turns once in some `turns`."""

    def gear(t: Array) -> tuple[Array, Array]:
        return np.vstack([t, contact(t)[:3]]), np.ones_like(t)

    def mate(t: Array) -> tuple[Array, Array]:
        found = contact(t)
        return np.array(list(RACK("mate", contact=found, a=distance).values())), found[3]

    all_turns = np.concatenate([breaks[:-1] + TURN * k for k in range(turns)] + [[breaks[0] + TURN * turns]])
    return Pair(
        PitchCurve.traced(gear, breaks, sense), PitchCurve.traced(mate, all_turns, -sense), float(distance), sense
    )


def of_stage(stage: Stage, parameters: Array, sense: int = 1) -> Pair:
    """The pair of a gear stage with its parameters [SI]: both segments of the deformed curve by themselves."""
    hoisted = stage.prologue(parameters=parameters)["hoisted"]

    def contact(t: Array) -> Array:
        return np.vstack(list(stage.contact(t=t, parameters=parameters, hoisted=hoisted).values()))

    joint = stage.polar(u=np.array([np.pi]), parameters=parameters)["t_first"][0, 0]
    return of_contact(contact, hoisted[0, 0], np.array([0.0, joint, TURN]), sense)


def circles(radius: float, mate: float) -> Pair:
    """Two circles."""

    def of(r: float, sense: int) -> PitchCurve:
        def trace(t: Array) -> tuple[Array, Array]:
            return np.array([t, np.full_like(t, r), np.zeros_like(t), np.zeros_like(t)]), np.ones_like(t)

        return PitchCurve.traced(trace, np.linspace(0, TURN, 3), sense)

    return Pair(of(radius, 1), of(mate, -1), radius + mate)
