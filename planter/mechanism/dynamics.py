"""Free motion of a mechanism: accelerations, integration on the constraints, equilibria, linearisation.

inertia accelerations = forces + slopes^T multipliers,    slopes accelerations = bends
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np
import scipy.integrate
import scipy.linalg
import scipy.optimize

from planter.errors import ComputationError, InputError
from planter.kernels import Array, Kernel
from planter.mechanism.file import MechanismFile

RANK = 1e-10
"""Singular values of the constraints below this share of the largest count as zero."""
ON = 1e-12
"""Gaps and speeds below this, in SI units, are closed."""
MOST = 30


@dataclass(frozen=True)
class Run:
    """A motion: times (n,) [s], states (2k, n) and accelerations (k, n) in SI, results (n,) by name."""

    times: Array
    states: Array
    accelerations: Array
    results: dict[str, Array]


class Dynamics:
    """A mechanism that moves by itself, with the values of its file; SI units and radians."""

    def __init__(self, file: MechanismFile) -> None:
        self.file, self.formulas, self.data = file, file.model, file.data()
        if "start" not in self.formulas.sidecar["functions"]:
            raise InputError(f"{file.source}: {file.name} is driven along an angle; `planter turn` takes it")
        self._stages = self.formulas.sidecar["functions"].keys()

    @property
    def names(self) -> list[str]:
        """Names of the coordinates, then of their rates."""
        return self.formulas.outputs("start")

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return len(self.names) // 2

    def start(self) -> Array:
        """The state (2k,) that the statement gives, brought onto the constraints."""
        return self.projected(0.0, np.array(list(self.formulas.at("start", data=self.data).values())))

    @cached_property
    def function(self) -> ca.Function:
        """(time, state) -> inertia (k, k), forces (k,), slopes (c, k), bends, speeds (c,), gaps (h,), as symbols."""
        time, state = ca.SX.sym("time"), ca.SX.sym("state", 2 * self.size)

        def of(stage: str) -> ca.SX:
            if stage not in self._stages:
                return ca.SX(0, 1)
            return self.formulas.function(stage)(time, self.data, state)

        square = ca.reshape(of("inertia"), self.size, self.size)
        slopes = of("slopes")
        rows = slopes.numel() // self.size
        parts = [square, of("forces"), ca.reshape(slopes, self.size, rows).T, of("bends"), of("speeds"), of("gaps")]
        return ca.Function("motion", [time, state], list(map(ca.densify, parts)), ["time", "state"],
                           ["inertia", "forces", "slopes", "bends", "speeds", "gaps"])  # fmt: skip

    @cached_property
    def _kernel(self) -> Kernel:
        return Kernel(self.function)

    def accelerations(self, time: float, state: Array) -> tuple[Array, Array]:
        """Accelerations (k,) and multipliers (c,) of the constraints, least squares where those are redundant."""
        now = self._kernel(time=time, state=state)
        inertia, slopes = now["inertia"], now["slopes"]
        count = len(slopes)
        if not count:
            found = np.linalg.solve(inertia, now["forces"][:, 0])
            return found.astype(float), np.empty(0)
        system = np.block([[inertia, -slopes.T], [slopes, np.zeros((count, count))]])
        found = np.linalg.lstsq(system, np.concatenate([now["forces"][:, 0], now["bends"][:, 0]]), rcond=RANK)[0]
        return found[: self.size], found[self.size :]

    def redundant(self, state: Array, time: float = 0.0) -> int:
        """How many constraints follow from the others in a state."""
        slopes = self._kernel(time=time, state=state)["slopes"]
        return len(slopes) - int(np.linalg.matrix_rank(slopes, RANK)) if len(slopes) else 0

    def projected(self, time: float, state: Array) -> Array:
        """The state nearest to one, by the inertia, that closes the gaps and keeps the speeds.

        Raises ComputationError where the constraints cannot be met from there.
        """
        if "speeds" not in self._stages:
            return state
        at = np.array(state, dtype=float)
        for _ in range(MOST):
            now = self._kernel(time=time, state=at)
            gaps = now["gaps"][:, 0]
            if np.all(np.abs(gaps) < ON):
                break
            at[: self.size] -= self._nearest(now["inertia"], now["slopes"][: len(gaps)], gaps)
        else:
            raise ComputationError(
                f"{self.file.name}: the loops do not close at {time:.6g} s: {np.abs(gaps).max():.3g} m"
            )
        now = self._kernel(time=time, state=at)
        at[self.size :] -= self._nearest(now["inertia"], now["slopes"], now["speeds"][:, 0])
        return at

    @staticmethod
    def _nearest(inertia: Array, slopes: Array, gaps: Array) -> Array:
        """The smallest step, by the inertia, that changes the gaps by what they are."""
        weighed = np.linalg.solve(inertia, slopes.T)
        found: Array = weighed @ np.linalg.lstsq(slopes @ weighed, gaps, rcond=RANK)[0]
        return found

    def run(self, times: Array, tolerance: float = 1e-10, state: Array | None = None) -> Run:
        """The motion at times (n,) [s] that rise, from the first of them on; by DOP853, projected after each step.

        Raises ComputationError where the integrator gives up.
        """
        times = np.asarray(times, dtype=float)
        at = self.start() if state is None else self.projected(times[0], state)
        solver = scipy.integrate.DOP853(self._rates, times[0], at, times[-1], rtol=tolerance, atol=1e-2 * tolerance)
        states = [at]
        while solver.status == "running":
            if (message := solver.step()) is not None:
                raise ComputationError(f"{self.file.name}: the motion stops at {solver.t:.6g} s: {message}")
            within = times[len(states) :][times[len(states) :] <= solver.t]
            dense = solver.dense_output() if len(within) else None
            states += [self.projected(t, dense(t)) for t in within if dense is not None]
            solver.y = self.projected(solver.t, solver.y)
            solver.f = solver.fun(solver.t, solver.y)
        return self._told(times, np.array(states).T)

    def _rates(self, time: float, state: Array) -> Array:
        return np.concatenate([state[self.size :], self.accelerations(time, state)[0]])

    def _told(self, times: Array, states: Array) -> Run:
        pairs = zip(times, states.T, strict=True)
        accelerations = np.array([self.accelerations(time, state)[0] for time, state in pairs]).T
        results = self.formulas("lane", time=times, data=self.data, state=states, accelerations=accelerations)
        return Run(times, states, accelerations, results)

    def equilibrium(self, state: Array | None = None) -> Array:
        """A state of rest (2k,) near one, the start unless told. Raises ComputationError where none is found."""
        at = self.start() if state is None else state
        count = len(self._kernel(time=0.0, state=at)["gaps"])

        def residual(x: Array) -> Array:
            now = self._kernel(time=0.0, state=np.concatenate([x[: self.size], np.zeros(self.size)]))
            push = now["slopes"][:count].T @ x[self.size :]
            return np.concatenate([now["forces"][:, 0] + push, now["gaps"][:, 0]])

        first = np.concatenate([at[: self.size], np.zeros(count)])
        found = scipy.optimize.least_squares(residual, first, xtol=1e-15, ftol=1e-15, gtol=1e-15)
        if np.abs(found.fun).max() > 1e-8:
            raise ComputationError(f"{self.file.name}: no state of rest is found near the given one")
        return np.concatenate([found.x[: self.size], np.zeros(self.size)])

    def eigenvalues(self, state: Array, time: float = 0.0) -> Array:
        """Eigenvalues (m,) [1/s] of small motions about a state of steady motion or rest, by falling real part.

        Those of the pencil of the linearised equations with their multipliers; infinite ones are left out.
        """
        push, pull = self._pencil(time, state)
        found = scipy.linalg.eigvals(pull, push)
        finite = found[np.isfinite(found) & (np.abs(found) < 1e9)]
        return finite[np.lexsort((-finite.imag, -finite.real))]

    def _pencil(self, time: float, state: Array) -> tuple[Array, Array]:
        """Matrices E, A of E x' = A x, x = (coordinates, rates, multipliers), about a state."""
        acceleration, multipliers = self.accelerations(time, state)
        symbol, k = ca.SX.sym("state", 2 * self.size), self.size
        inertia, forces, slopes, _, speeds, gaps = self.function(time, symbol)
        force = forces + slopes.T @ multipliers - inertia @ acceleration
        held = ca.vertcat(gaps, speeds[gaps.numel() :])
        at = ca.Function("about", [symbol], [ca.jacobian(force, symbol), ca.jacobian(held, symbol), inertia, slopes])
        by_state, by_held, mass, rows = (np.array(part) for part in at(state))
        count = len(rows)
        push = scipy.linalg.block_diag(np.eye(k), mass, np.zeros((count, count)))
        pull = np.zeros_like(push)
        pull[:k, k : 2 * k] = np.eye(k)
        pull[k : 2 * k, : 2 * k], pull[k : 2 * k, 2 * k :] = by_state, rows.T
        pull[2 * k :, : 2 * k] = by_held
        return push, pull
