"""A gear stage of a machine: a generated pitch-curve family, its names in the design vector, its checks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from planter.errors import GeometryError
from planter.files import units
from planter.gearing import families
from planter.kernels import Array, Kernel

TAIL = 1e-12
"""Largest coefficient of a series that may be left out [-]."""
FIRST_TERMS, MOST_TERMS = 16, 1024


@dataclass(frozen=True)
class Candidate:
    """Parameters of a stage in SI, and where each of them stands: its file and key."""

    parameters: Array
    key: Callable[[str], str]


def names(family: str, vector: dict[str, Any]) -> tuple[str, ...]:
    """Design names of a family's parameters: numbered with the gear, the deformation coefficient's own name last.

    >>> names("ellipse", {"suffix": "6", "known": {"-1": {"shown": "m61"}}})
    ('A6_mm', 'k6', 'm61')
    """
    *own, _ = (entry["shown"] for entry in families.sidecar(family)["parameters"])
    numbered = (f"{base}{vector['suffix']}{dash}{unit}" for base, dash, unit in (n.partition("_") for n in own))
    return (*numbered, vector["known"]["-1"]["shown"])


@dataclass(frozen=True)
class Stage:
    """A pitch curve with its conjugate; `terms` is the length of the series of its rotation."""

    family: str
    names: tuple[str, ...]
    terms: int = 0

    @cached_property
    def sidecar(self) -> dict[str, Any]:
        return families.sidecar(self.family)

    @cached_property
    def prologue(self) -> Kernel:
        return Kernel(families.module(self.family).prologue(self.terms))

    @cached_property
    def tangent(self) -> Kernel:
        """Jacobian of the prologue in the parameters, sparse."""
        return Kernel(families.module(self.family).tangent(self.terms))

    @cached_property
    def contact(self) -> Kernel:
        return Kernel(families.module(self.family).contact(self.terms), lanes=["t"])

    @cached_property
    def curvature(self) -> Kernel:
        """(u, parameters, hoisted) -> curvatures [1/m] of the gear and its conjugate on both segments, u in [0, pi]."""
        return Kernel(families.module(self.family).curvature(self.terms), lanes=["u"])

    @cached_property
    def polar(self) -> Kernel:
        """(u, parameters) -> polar angles of the gear [rad] at u on both segments."""
        return Kernel(families.module(self.family).polar(), lanes=["u"])

    @cached_property
    def conditions(self) -> Kernel:
        """(parameters) -> what must be positive, as the sidecar's conditions say."""
        return Kernel(families.module(self.family).conditions())

    def check_parameters(self, candidate: Candidate) -> None:
        """Raise GeometryError, naming file, key, value and bound, where a condition of the family fails."""
        order = [entry["name"] for entry in self.sidecar["parameters"]]
        values = self.conditions(parameters=candidate.parameters).values()
        for condition, value in zip(self.sidecar["conditions"], values, strict=True):
            if value[0, 0] <= 0:
                index = order.index(condition["name"])
                name = self.names[index]
                given = candidate.parameters[index] / units.factor(name)
                allowed = f"it must be {condition['allowed']}"
                raise GeometryError(f"{candidate.key(name)} = {given:.12g} is not allowed: {allowed}")

    def check_radius(self, candidate: Candidate) -> None:
        """Raise GeometryError, naming curve and angle, where a radius is not between 0 and the centre distance."""
        hoisted = self.prologue(parameters=candidate.parameters)["hoisted"]
        t = np.linspace(0, 2 * np.pi, 720, endpoint=False)
        radius = self.contact(t=t, parameters=candidate.parameters, hoisted=hoisted)["r"][0]
        distance = hoisted[0, 0]
        worst = int(np.argmax(np.abs(radius - distance / 2)))
        if not 0 < radius[worst] < distance:
            raise GeometryError(
                f"{candidate.key(self.names[0])}: on the {self.sidecar['title']} r = {radius[worst] * 1e3:.6g} mm at "
                f"t = {np.degrees(t[worst]):.6g} deg is not allowed: it must be between 0 and the centre distance, "
                f"{distance * 1e3:.6g} mm"
            )

    def tail(self, parameters: Array) -> float:
        """Size of the last coefficients of the series [-]; as many as a curve of several lobes has gaps between."""
        hoisted = self.prologue(parameters=parameters)["hoisted"][:, 0]
        return float(np.abs(hoisted[1:][-max(3, self.terms // 8) :]).max(initial=0.0))


def build(family: str, vector: dict[str, Any], candidates: Sequence[Candidate]) -> Stage:
    """A stage with as many terms as its series needs for every candidate.

    Raises GeometryError where a curve cannot be built or its series does not converge.
    """
    stage = Stage(family, names(family, vector))
    for candidate in candidates:
        stage.check_parameters(candidate)
    stage = converged(stage, candidates)
    for candidate in candidates:
        stage.check_radius(candidate)
    return stage


def converged(stage: Stage, candidates: Sequence[Candidate]) -> Stage:
    """The stage with as many terms as its series needs for every candidate; GeometryError where none are enough."""
    terms = FIRST_TERMS if stage.sidecar["series"] else 0
    while terms <= MOST_TERMS:
        stage = Stage(stage.family, stage.names, terms)
        tails = [stage.tail(candidate.parameters) for candidate in candidates]
        if max(tails) < TAIL:
            return stage
        terms += terms // 2
    worst = candidates[int(np.argmax(tails))]
    raise GeometryError(
        f"{worst.key(stage.names[0])}: the series of the {stage.sidecar['title']}'s rotation has not converged to "
        f"{TAIL:g} with {stage.terms} terms: the curve must be rounder"
    )
