"""Pairs of pitch curves that roll on each other: of a stage, of circles, of any contact by the polar angle."""

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
class CurvePair:
    """A gear's pitch curve and its mate's, the distance of their axes [m], and the sense of the gear's polar angle.

    At rolling length s the gear touches at its arc length sense * s, the mate at -sense * s.
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
        """Signs of both curves' arc length relative to the rolling length."""
        return self.sense, -self.sense

    def scaled(self, factor: float) -> CurvePair:
        """Return the pair with all lengths multiplied by a factor."""
        return CurvePair(self.gear.scaled(factor), self.mate.scaled(factor), self.distance * factor, self.sense)


def build_contact_pair(contact: Contact, distance: float, breaks: Array, sense: int = 1, turns: int = 1) -> CurvePair:
    """Build the pair of a contact that is smooth between breaks (m,) [rad]; the mate turns once in `turns`."""

    def gear(t: Array) -> tuple[Array, Array]:
        return np.vstack([t, contact(t)[:3]]), np.ones_like(t)

    def mate(t: Array) -> tuple[Array, Array]:
        columns = contact(t)
        return np.array(list(RACK("mate", contact=columns, a=distance).values())), columns[3]

    all_turns = np.concatenate([breaks[:-1] + TURN * k for k in range(turns)] + [[breaks[0] + TURN * turns]])
    return CurvePair(
        PitchCurve.from_trace(gear, breaks, sense),
        PitchCurve.from_trace(mate, all_turns, -sense),
        float(distance),
        sense,
    )


def build_stage_pair(stage: Stage, parameters: Array, sense: int = 1) -> CurvePair:
    """Build the pair of a gear stage with its parameters (q,) in SI, with separate segments of the deformed curve."""
    hoisted = stage.prologue(parameters=parameters)["hoisted"]

    def contact(t: Array) -> Array:
        return np.vstack(list(stage.contact(t=t, parameters=parameters, hoisted=hoisted).values()))

    joint = stage.polar(u=np.array([np.pi]), parameters=parameters)["t_first"][0, 0]
    return build_contact_pair(contact, hoisted[0, 0], np.array([0.0, joint, TURN]), sense)


def build_circle_pair(radius: float, mate: float) -> CurvePair:
    """Build the pair of two circles by their radii [m]."""

    def trace_circle(r: float, sense: int) -> PitchCurve:
        def trace(t: Array) -> tuple[Array, Array]:
            return np.array([t, np.full_like(t, r), np.zeros_like(t), np.zeros_like(t)]), np.ones_like(t)

        return PitchCurve.from_trace(trace, np.linspace(0, TURN, 3), sense)

    return CurvePair(trace_circle(radius, 1), trace_circle(mate, -1), radius + mate)
