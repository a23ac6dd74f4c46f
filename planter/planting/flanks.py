"""Laws of the cam's flanks that were generated: by their names in machine files, and where they are not smooth."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import casadi as ca
import numpy as np

from planter.kernels import Kernel, generated

_PREFIX = "flank_"
_BESIDE = 1e-7
"""How far beside a position the derivatives of a law are taken."""
_JUMP = 1e-2
"""A derivative that differs by less on both sides of a position is continuous there; those of a law are from 1 up."""
SECOND = 2
"""Forces follow the second derivative of a law."""


@cache
def _modules() -> dict[str, str]:
    return {generated.sidecar(name)["title"]: name for name in generated.names(_PREFIX)}


def names() -> tuple[str, ...]:
    """Names of the laws."""
    return tuple(_modules())


def module_name(name: str) -> str:
    """The generated module of a law."""
    return _modules()[name]


@cache
def function(name: str) -> ca.Function:
    """x -> p, dp, ddp: share of the rise at a position x in [0, 1] of the flank, and its slopes."""
    law = generated.module(module_name(name)).law()
    x = ca.SX.sym("x")
    return ca.Function("flank", [x], ca.vertsplit(law(x)), ["x"], ["p", "dp", "ddp"])


@dataclass(frozen=True)
class Joint:
    """A position in a flank, and the order of the first derivative of the forces in the angle that jumps there."""

    position: float
    order: int


@cache
def joints(name: str, positions: tuple[float, ...]) -> tuple[Joint, ...]:
    """Those of some positions in [0, 1] where a law, at rest before and after, is not smooth: jumps up to order 2."""
    x = ca.SX.sym("x")
    derivatives = [function(name)(x)[SECOND]]
    for _ in range(2):
        derivatives.append(ca.jacobian(derivatives[-1], x))
    values = Kernel(
        ca.Function("derivatives", [x], [ca.densify(ca.vertcat(*derivatives))], ["x"], ["found"]), lanes=["x"]
    )
    beside = np.add.outer(np.array(positions), [-_BESIDE, _BESIDE])
    found = values(x=np.clip(beside, 0, 1).ravel())["found"].reshape(len(derivatives), *beside.shape)
    found = np.where((beside < 0) | (beside > 1), 0.0, found)
    jumps = np.abs(found[..., 1] - found[..., 0]) > _JUMP
    return tuple(Joint(x, int(order.argmax())) for x, order in zip(positions, jumps.T, strict=True) if order.any())
