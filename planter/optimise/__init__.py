"""Optimisation of a device's design: least range and spread of its support force within the bounds.

`run` is the whole of it; `sensitivity` says which parameters matter at all, `front` weighs range against variance and
`joints` lists where the force curve is not smooth. Nothing heavy is imported before one of them is used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable

    from planter.kernels import Array
    from planter.optimise.hybrid import Method
    from planter.optimise.joints import Place
    from planter.optimise.pareto import Compromise
    from planter.optimise.problem import Sampling
    from planter.optimise.progress import Progress
    from planter.optimise.result import Result
    from planter.planting.model import Device

__all__ = ["front", "joints_of", "run", "sensitivity"]


def run(
    device: Device,
    method: Method = "hybrid",
    samples: Sampling | None = None,
    seed: int = 0,
    starts: int | None = None,
    progress: Callable[[Progress], None] | None = None,
) -> Result:
    """The best design of a device within its bounds, with its certificate.

    `samples` angles of a turn, or "refined" for true extremes and integrals; None: as the machine file says. `starts`
    is the number of IPOPT's starts, `progress` is told how far the search is.

    Raises InputError for an unknown method; on KeyboardInterrupt `planter.optimise.result.Interrupted`, whose `best`
    is the result so far.
    """
    from planter.optimise import hybrid

    return hybrid.run(device, method, samples, seed, starts, progress)


def sensitivity(device: Device, x: Array, samples: int) -> dict[str, Any]:
    """`effective_parameters` and `insensitive` of the support-force curve at design x (p,), ready for JSON."""
    from planter.optimise import directions
    from planter.optimise.response import Planting

    found = directions.sensitivity(Planting(device), x, samples)
    return {"effective_parameters": found.effective_parameters, "insensitive": found.named}


def front(device: Device, samples: Sampling | None = None, points: int = 15) -> list[Compromise]:
    """The Pareto front of range against variance, from least range to least variance."""
    from planter.optimise import pareto

    return pareto.front(device, samples, points)


def joints_of(device: Device, x: Array) -> list[Place]:
    """Joints of both sides over a turn at design x (p,), by angle in [0, 2 pi)."""
    from planter.optimise import joints
    from planter.optimise.response import Planting

    response = Planting(device)
    return joints.places(response, response.prologue(x))
