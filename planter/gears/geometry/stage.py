"""Gear stages of a machine: a generated pitch-curve family, its names in the design vector, checks,
and pitch lengths.

Arc length per parameter u is even and periodic on either segment, so that its mean over midpoints
converges faster than any power of their number (Trefethen and Weideman, The exponentially
convergent trapezoidal rule, 2014).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np

from planter.errors import GeometryError
from planter.files import units
from planter.gears.geometry import families
from planter.kernels import Array, Kernel
from planter.numerics.arrays import LastCallCache

SERIES_TOLERANCE = 1e-12
"""Largest coefficient of a series that may be truncated [-]."""
FIRST_TERMS, MAX_TERMS = 16, 1024


@dataclass(frozen=True)
class StageCandidate:
    """Parameters of a stage in SI, and a function that names the file and key of each."""

    parameters: Array
    key: Callable[[str], str]


def list_design_names(family: str, vector: dict[str, Any]) -> tuple[str, ...]:
    """Return the design names of a family's parameters, numbered with the gear, the deformation
    coefficient last.

    >>> list_design_names("ellipse", {"suffix": "6", "known": {"-1": {"shown": "m61"}}})
    ('A6_mm', 'k6', 'm61')
    """
    *shown_names, _ = (entry["shown"] for entry in families.load_sidecar(family)["parameters"])
    numbered = (
        f"{base}{vector['suffix']}{dash}{unit}"
        for base, dash, unit in (n.partition("_") for n in shown_names)
    )
    return (*numbered, vector["known"]["-1"]["shown"])


@dataclass(frozen=True)
class Stage:
    """A pitch curve with its conjugate; `terms` is the length of the series of its rotation."""

    family: str
    names: tuple[str, ...]
    terms: int = 0

    @cached_property
    def sidecar(self) -> dict[str, Any]:
        return families.load_sidecar(self.family)

    @cached_property
    def prologue(self) -> Kernel:
        return Kernel(families.load_functions(self.family).prologue(self.terms))

    @cached_property
    def tangent(self) -> Kernel:
        """Jacobian of the prologue in the parameters, sparse."""
        return Kernel(families.load_functions(self.family).tangent(self.terms))

    @cached_property
    def contact(self) -> Kernel:
        return Kernel(families.load_functions(self.family).contact(self.terms), lanes=["t"])

    @cached_property
    def curvature(self) -> Kernel:
        """(u, parameters, hoisted) -> curvatures [1/m] of the gear and its conjugate on both
        segments, u in [0, pi].
        """
        return Kernel(families.load_functions(self.family).curvature(self.terms), lanes=["u"])

    @cached_property
    def polar(self) -> Kernel:
        """(u, parameters) -> polar angles of the gear [rad] at u on both segments."""
        return Kernel(families.load_functions(self.family).polar(), lanes=["u"])

    @cached_property
    def conditions(self) -> Kernel:
        """(parameters) -> values that must be positive, in the order of the sidecar's
        conditions.
        """
        return Kernel(families.load_functions(self.family).conditions())

    def check_parameters(self, candidate: StageCandidate) -> None:
        """Raise GeometryError, naming file, key, value and bound, if a condition of the family
        fails.
        """
        order = [entry["name"] for entry in self.sidecar["parameters"]]
        values = self.conditions(parameters=candidate.parameters).values()
        for condition, value in zip(self.sidecar["conditions"], values, strict=True):
            if value[0, 0] <= 0:
                index = order.index(condition["name"])
                name = self.names[index]
                value_shown = candidate.parameters[index] / units.unit_factor(name)
                allowed = f"it must be {condition['allowed']}"
                raise GeometryError.for_value(candidate.key(name), f"{value_shown:.12g}", allowed)

    def check_radius(self, candidate: StageCandidate) -> None:
        """Raise GeometryError, naming curve and angle, if a radius is not between 0 and the centre
        distance.
        """
        hoisted = self.prologue(parameters=candidate.parameters)["hoisted"]
        t = np.linspace(0, 2 * np.pi, 720, endpoint=False)
        radius = self.contact(t=t, parameters=candidate.parameters, hoisted=hoisted)["r"][0]
        distance = hoisted[0, 0]
        worst = int(np.argmax(np.abs(radius - distance / 2)))
        if not 0 < radius[worst] < distance:
            raise GeometryError(
                f"{candidate.key(self.names[0])}: on the {self.sidecar['title']} r = "
                f"{radius[worst] * 1e3:.6g} mm at "
                f"t = {np.degrees(t[worst]):.6g} deg: it must be between 0 and the centre "
                f"distance, "
                f"{distance * 1e3:.6g} mm"
            )

    def tail(self, parameters: Array) -> float:
        """Return the magnitude of the last coefficients of the series [-], enough to span the gaps
        of a lobed curve.
        """
        hoisted = self.prologue(parameters=parameters)["hoisted"][:, 0]
        return float(np.abs(hoisted[1:][-max(3, self.terms // 8) :]).max(initial=0.0))


def build_stage(family: str, vector: dict[str, Any], candidates: Sequence[StageCandidate]) -> Stage:
    """Build a stage with as many terms as its series needs for every candidate.

    Raises GeometryError if a curve cannot be built or its series does not converge.
    """
    stage = Stage(family, list_design_names(family, vector))
    for candidate in candidates:
        stage.check_parameters(candidate)
    stage = converge_series(stage, candidates)
    for candidate in candidates:
        stage.check_radius(candidate)
    return stage


def converge_series(stage: Stage, candidates: Sequence[StageCandidate]) -> Stage:
    """Return the stage with as many terms as its series needs.

    Raises GeometryError if it does not converge.
    """
    terms = FIRST_TERMS if stage.sidecar["series"] else 0
    while terms <= MAX_TERMS:
        stage = Stage(stage.family, stage.names, terms)
        tails = [stage.tail(candidate.parameters) for candidate in candidates]
        if max(tails) < SERIES_TOLERANCE:
            return stage
        # by half as much again: twice as many would mostly be too many
        terms += terms // 2
    worst = candidates[int(np.argmax(tails))]
    raise GeometryError(
        f"{worst.key(stage.names[0])}: the series of the {stage.sidecar['title']}'s rotation has "
        f"not converged to "
        f"{SERIES_TOLERANCE:g} with {stage.terms} terms: the curve must be rounder"
    )


FIRST_NODES, MAX_NODES = 16, 4096
LENGTH_TOLERANCE = 1e-14
"""Relative change of the length on doubling the nodes at which it has converged."""


@dataclass(frozen=True)
class LengthDerivatives:
    """A length [m] with its gradient (q,) and its Hessian (q, q) in a stage's parameters in SI."""

    value: float
    gradient: Array
    hessian: Array


class PitchLength:
    """The length of a stage's inner pitch curve and of its mate's, accurate to rounding at
    `candidates`.

    `at` returns it at parameters (q,) in SI. Raises GeometryError, naming the candidate, if a curve
    needs too many nodes.
    """

    def __init__(self, stage: Stage, candidates: Sequence[StageCandidate]) -> None:
        self._kernel = Kernel(
            _build_rates(families.load_functions(stage.family).speed()), lanes=["u"]
        )
        self.nodes = max(self._count_nodes(stage, candidate) for candidate in candidates)
        self.at = LastCallCache(lambda parameters: self._integrate(parameters, self.nodes))

    def _integrate(self, parameters: Array, nodes: int) -> LengthDerivatives:
        # midpoints: the integrand is even and periodic, so that they converge exponentially
        u = np.pi / nodes * (np.arange(nodes) + 0.5)
        sums = self._kernel(u=u, parameters=parameters)["rates"].sum(axis=1) * np.pi / nodes
        q = len(parameters)
        return LengthDerivatives(float(sums[0]), sums[1 : 1 + q], sums[1 + q :].reshape(q, q))

    def _count_nodes(self, stage: Stage, candidate: StageCandidate) -> int:
        """Return the number of nodes that a candidate's curve needs."""
        nodes, value = FIRST_NODES, np.inf
        while nodes <= MAX_NODES:
            before, value = value, self._integrate(candidate.parameters, nodes).value
            if abs(value - before) <= LENGTH_TOLERANCE * value:
                return nodes
            nodes *= 2
        raise GeometryError(
            f"{candidate.key(stage.names[0])}: the length of the {stage.sidecar['title']} has not "
            f"converged to "
            f"{LENGTH_TOLERANCE:g} with {MAX_NODES} nodes: the curve must be rounder"
        )


def _build_rates(speed: ca.Function) -> ca.Function:
    """Return the function (u, parameters) -> arc length per u of both segments, gradient and
    Hessian in a column.
    """
    u, p = ca.SX.sym("u"), ca.SX.sym("parameters", speed.size1_in(1))
    first, second = speed.call([u, p])
    hessian, gradient = ca.hessian(first + second, p)
    rates = ca.vertcat(first + second, gradient, ca.vec(ca.densify(hessian)))
    return ca.Function("length", [u, p], [rates], ["u", "parameters"], ["rates"])
