"""Length of a stage's pitch curve over the stage's parameters, with exact derivatives.

Arc length per parameter u is even and periodic on either segment, so that its mean over midpoints converges faster than
any power of their number (Trefethen and Weideman, The exponentially convergent trapezoidal rule, 2014).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from planter.errors import GeometryError
from planter.gearing import families
from planter.gearing.stage import Candidate, Stage
from planter.kernels import Array, Kernel
from planter.numerics.latest import Latest

FIRST_NODES, MOST_NODES = 16, 4096
TAIL = 1e-14
"""Share of the length that twice as many nodes may change."""


@dataclass(frozen=True)
class Length:
    """A length [m] with its gradient (q,) and its Hessian (q, q) in a stage's parameters in SI."""

    value: float
    gradient: Array
    hessian: Array


class PitchLength:
    """The length of a stage's inner pitch curve and of its mate's, right to rounding at `candidates`.

    `at` gives it at parameters (q,) in SI. Raises GeometryError, naming the candidate, for a curve that takes too many
    nodes.
    """

    def __init__(self, stage: Stage, candidates: Sequence[Candidate]) -> None:
        self._kernel = Kernel(_speeds(families.module(stage.family).speed()), lanes=["u"])
        self.nodes = max(self._needed(stage, one) for one in candidates)
        self.at = Latest(lambda parameters: self._length(parameters, self.nodes))

    def compile(self) -> None:
        """Find lengths in the fastest way that there is here."""
        self._kernel.compile()

    def _length(self, parameters: Array, nodes: int) -> Length:
        u = np.pi / nodes * (np.arange(nodes) + 0.5)
        sums = self._kernel(u=u, parameters=parameters)["rates"].sum(axis=1) * np.pi / nodes
        q = len(parameters)
        return Length(float(sums[0]), sums[1 : 1 + q], sums[1 + q :].reshape(q, q))

    def _needed(self, stage: Stage, candidate: Candidate) -> int:
        """How many nodes a candidate's curve takes."""
        nodes, value = FIRST_NODES, np.inf
        while nodes <= MOST_NODES:
            before, value = value, self._length(candidate.parameters, nodes).value
            if abs(value - before) <= TAIL * value:
                return nodes
            nodes *= 2
        raise GeometryError(
            f"{candidate.key(stage.names[0])}: the length of the {stage.sidecar['title']} has not converged to "
            f"{TAIL:g} with {MOST_NODES} nodes: the curve must be rounder"
        )


def _speeds(speed: ca.Function) -> ca.Function:
    """(u, parameters) -> arc length per u of both segments together, its gradient and its Hessian, in one column."""
    u, p = ca.SX.sym("u"), ca.SX.sym("parameters", speed.size1_in(1))
    first, second = speed.call([u, p])
    hessian, gradient = ca.hessian(first + second, p)
    rates = ca.vertcat(first + second, gradient, ca.vec(ca.densify(hessian)))
    return ca.Function("length", [u, p], [rates], ["u", "parameters"], ["rates"])
