"""A machine's quantities by another route than the engine's: its functions called angle by angle,
loops by SciPy.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np
from scipy.optimize import fsolve

from planter.engine.machine import Machine
from planter.kernels import Array

STEPS = 72
"""Steps of the walk from the start of a turn to where loops are wanted."""


def evaluate(machine: Machine, name: str, phi: Array) -> Array:
    """Return a quantity (n,) of a machine's own data at angles (n,) [rad], in the unit of its key;
    of side 1.
    """
    quantity = machine.find_quantity(name)
    sides = [column.name for column in machine.quantities if not column.total]
    d = machine.data
    h = np.asarray(machine.prologue(d)).ravel()

    def side(angle: float, q: Array) -> Array:
        return np.asarray(machine.lane(angle, d, h, q)).ravel()

    rows = []
    for angle, q in _walk(machine, np.asarray(phi, dtype=float)):
        if quantity.total:
            totals = [column.name for column in machine.quantities if column.total]
            assert machine.totals is not None
            both = machine.totals(*(side(angle + offset, q) for offset in machine.offsets), d)
            rows.append(np.asarray(both).ravel()[totals.index(quantity.name)])
        else:
            rows.append(side(angle, q)[sides.index(quantity.name)])
    return np.array(rows) / quantity.factor


def _walk(machine: Machine, phi: Array) -> Iterator[tuple[float, Array]]:
    """Yield angles with the coordinates of closed loops (c,): from the assembly at zero, from one
    to the next.
    """
    q, at = np.zeros(0), 0.0
    if (loops := machine.loops) is not None:
        q = np.asarray(loops.assembly(machine.data)).ravel()
    for angle in phi:
        if loops is not None:
            count = max(1, int(np.ceil(STEPS * abs(angle - at) / (2 * np.pi))))
            for step in np.linspace(at, angle, count + 1):
                gaps = partial(_gaps, machine, step)
                q = fsolve(gaps, q, xtol=1e-13, full_output=True)[0]
                assert np.abs(gaps(q)).max() < 1e-12, f"the loops do not close at {step} rad"
            at = float(angle)
        yield float(angle), q


def _gaps(machine: Machine, angle: float, q: Array) -> Array:
    assert machine.loops is not None
    return np.asarray(machine.loops.gaps(angle, machine.data, q)).ravel()[: len(q)]
