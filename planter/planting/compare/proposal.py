"""Where no pair keeps the requirements: which ones conflict everywhere, and the nearest set that does not."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from planter.planting.compare import box
from planter.planting.file import Machine
from planter.planting.model import Device
from planter.planting.requirements.constraints import Required
from planter.planting.results import ComparedPair, Proposal


def proposal(machine: Machine, ranked: Sequence[ComparedPair]) -> Proposal | None:
    """None where a device is feasible; else the requirements that every device breaks, and relaxed limits.

    The limits are those that the nearest device keeps; `violation` is what is left of that device's, in steps,
    under them.
    """
    if not ranked or ranked[0].feasible:
        return None
    nearest = ranked[0]
    limits = {one.key: one.relaxed for one in nearest.violations}
    everywhere = set.intersection(*({one.name for one in entry.violations} for entry in ranked))
    return Proposal(
        conflicting=sorted(everywhere),
        limits=limits,
        stage1=nearest.stage1,
        stage2=nearest.stage2,
        violation=left(machine, nearest, limits),
    )


def left(machine: Machine, entry: ComparedPair, limits: dict[str, float]) -> float:
    """The largest violation [steps] of an entry's design once limits are set anew."""
    changed = machine.with_numbers({f"requirements.{key}": value for key, value in limits.items()})
    device = Device(box.described(changed, (entry.stage1, entry.stage2)))
    x = device.scale * np.array([entry.design[name] for name in device.names])
    return Required(device).violation(x)
