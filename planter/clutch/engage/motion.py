"""Integration of a clutch's motion with CVODES, and what is read from it.

Steps are chosen by the integrator's error control, which sees every contact begin and end: the forces are continuous
there, and no step is longer than `LONGEST`. States come out on a fine grid; peaks are then looked for between points.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from planter.clutch.engage.dynamics import ANGLE, FREE, OUTPUT, POWERS, TIME, WORKS, Array, Clutch
from planter.clutch.engage.inputs import Inputs
from planter.clutch.results.engagement import Energy
from planter.kernels import Kernel

STEP = 2e-5
"""Distance of the points of the grid [s]."""
LONGEST = 5e-5
"""Longest step of the integrator [s]: at the speeds of a planter, contacts close by a few micrometres in it."""
TOLERANCE = 1e-9
"""Relative tolerance; the absolute one is a thousandth of it, in SI units."""
FINE = 64
"""Points between two of the grid when a peak is looked for."""


@dataclass(frozen=True)
class Run:
    """A motion on a grid: states (SIZE, n), and what is seen of them, rows by name."""

    clutch: Clutch
    inputs: Inputs
    states: Array
    seen: dict[str, Array]
    tolerance: float

    @property
    def time(self) -> Array:
        """Time since the link began to move [s], (n,)."""
        return self.states[TIME]

    @property
    def load(self) -> Array:
        """Sum of the normal forces on teeth or jaws [N], (n,)."""
        return self.seen["load"][0]

    @property
    def speed(self) -> Array:
        """Speed of the output [rad/s], (n,)."""
        return self.states[FREE + OUTPUT]

    @property
    def ahead(self) -> Array:
        """Rotation of the input against the output [rad], (n,)."""
        return self.states[ANGLE] - self.states[OUTPUT]

    def energy(self) -> Energy:
        """Work put in, energy kept, work lost, and what is missing of their balance [J]."""
        work = dict(zip(POWERS, self.states[WORKS:, -1] - self.states[WORKS:, 0], strict=True))
        given = work["input"] + work["linkage"]
        lost = sum(work.values()) - given
        kept = float(self.seen["energy"][0, -1] - self.seen["energy"][0, 0])
        return Energy(input_J=given, stored_J=kept, lost_J=lost, imbalance_J=given - kept - lost)

    def peak(self) -> float:
        """Largest load [N], looked for between the points of the grid."""
        top = max(int(np.argmax(self.load)) - 1, 0)
        near = integrate(self.clutch, self.inputs, self.states[:, top], 2 * STEP, STEP / FINE, self.tolerance)
        return float(max(near.load.max(), self.load.max()))


def integrate(
    clutch: Clutch,
    inputs: Inputs,
    start: Array,
    duration: float,
    step: float = STEP,
    tolerance: float = TOLERANCE,
) -> Run:
    """The motion from a state (SIZE,) over a duration [s]. Raises ComputationError where the integrator gives up."""
    vector = inputs.vector()
    count = round(duration / step)
    motion = _integrator(clutch, count, duration, tolerance)
    ran = motion(x0=start, p=vector)["x"]
    states = np.column_stack([start, ran])
    return Run(clutch, inputs, states, clutch.columns(states, vector), tolerance)


def _integrator(clutch: Clutch, count: int, duration: float, tolerance: float) -> Kernel:
    options = {
        "reltol": tolerance,
        "abstol": 1e-3 * tolerance,
        "max_step_size": min(LONGEST, duration),
        "max_num_steps": 10_000_000,
    }
    grid = np.linspace(0, duration, count + 1)[1:]
    solver = ca.integrator("motion", "cvodes", clutch.dae, 0, grid, options)
    start, p = ca.MX.sym("x0", clutch.dae["x"].shape[0]), ca.MX.sym("p", clutch.dae["p"].shape[0])
    return Kernel(ca.Function(f"{clutch.name}_motion", [start, p], [solver(x0=start, p=p)["xf"]], ["x0", "p"], ["x"]))
