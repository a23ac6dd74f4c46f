"""Ensembles of free motions from perturbed starts: bands, statistics of the runs, and the growth of
their separation.

The largest Lyapunov exponent follows from a companion of each run whose separation is brought back
to a small size at every output time: G. Benettin et al., Meccanica 15 (1980), part 2; events are
integrated as in every other run.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise

import numpy as np
from threadpoolctl import threadpool_limits

from planter.errors import ComputationError, InputError
from planter.files import units
from planter.jobs import run_in_order
from planter.kernels import Array, Integers
from planter.mechanism.dynamics import Dynamics, MotionRun
from planter.mechanism.file import MechanismFile
from planter.mechanism.motion import list_start_changes
from planter.mechanism.results import (
    EnsembleQuantity,
    EnsembleResult,
    EnsembleSeparation,
    EnsembleStatistic,
    LyapunovExponent,
)
from planter.progress import Listener, ProgressPhase
from planter.task import AUTO, Means, Task

TURN = 2 * math.pi
PARTED = 0.1
"""Separation from which two runs have parted, as a share of the ranges of the states."""
COMPANION = 1e-6
"""Separation of a run and its companion at each output time, as a share of the ranges."""
MOST_SEPARATION = 0.03
"""Separation of a companion up to which it grows as a small one does, as a share of the ranges."""
QUANTILES = (5, 25, 50, 75, 95)
"""Percentiles of a band."""
LEAST_POINTS = 8
"""Output times that a period must have."""
MOST_VALUES = 50_000_000
"""Values of all runs that are held at once: 400 MB."""


@dataclass(frozen=True)
class EnsembleSpec:
    """Settings of an ensemble: `runs` from random starts, which `seed` determines, statistics of
    them from `since` [s].

    A start differs from the statement's by uniform deviates of each coordinate and rate within
    `perturbation`, as a share of the entry's range in the motion from the stated start, from
    `since` on. Statistics are those of each `period` [s] after `since`, or of all the time after it
    if that is None.
    """

    runs: int
    perturbation: float = 1e-3
    since: float = 0.0
    period: float | None = None
    seed: int = 0


@dataclass(frozen=True)
class EnsembleRun:
    """A run: columns (n,) by name in SI, separation (n,) from the stated motion, growth (n - 1,) of
    its companion.

    Separations are shares of the ranges of the states. Growths are natural logarithms from one
    output time to the next; `reach` is the largest separation of the companion.
    """

    columns: Mapping[str, Array]
    separation: Array
    growth: Array
    reach: float


@dataclass(frozen=True)
class MechanismEnsemble:
    """An ensemble: times (n,) [s], curves (runs, n) by key in display units with meanings,
    separation (runs, n).

    `pieces` (runs, periods) by key hold the range, the variance and the peak of each piece of each
    run.
    """

    times: Array
    curves: dict[str, Array]
    meanings: dict[str, str]
    separation: Array
    pieces: dict[str, dict[str, Array]]
    result: EnsembleResult

    @property
    def bands(self) -> dict[str, Array]:
        """Percentiles (5, n) of each curve, those of QUANTILES, in display units by key."""
        return {key: np.percentile(curve, QUANTILES, axis=0) for key, curve in self.curves.items()}


@dataclass(frozen=True)
class StateMetric:
    """Separation of two states (2k,): root mean square of the differences over `scales` (2k,) that
    are not zero.

    Differences of coordinates that are `angles` (2k,) count without whole turns.
    """

    scales: Array
    angles: Array

    @classmethod
    def from_motion(cls, dynamics: Dynamics, times: Array, states: Array) -> StateMetric:
        """Return the metric whose scales are the ranges of states (2k, n) at times (n,) [s].

        A coordinate's range is that about its linear trend, at most a whole turn for an angle.
        Raises ComputationError if no entry changes.
        """
        entries = dynamics.formulas.sidecar["vectors"]["start_state"]
        angles = np.array([entry["unit"] == "rad" for entry in entries])
        scales = np.ptp(states, axis=1)
        size = dynamics.size
        trends = np.polyfit(times - times[0], states[:size].T, 1)
        scales[:size] = np.ptp(states[:size] - np.outer(trends[0], times - times[0]), axis=1)
        scales[angles] = np.minimum(scales[angles], TURN)
        sizes = np.abs(states).max(axis=1)
        scales[scales <= 1e3 * np.finfo(float).eps * sizes] = 0.0
        if not scales.any():
            raise ComputationError(f"{dynamics.file.name}: nothing moves from the stated start")
        return cls(scales, angles)

    def measure(self, states: Array, references: Array) -> Array:
        """Return the separations (n,) of states (2k, n) from references (2k, n)."""
        differences = states - references
        turns = np.round(differences[self.angles] / TURN)
        differences[self.angles] -= TURN * turns
        moving = self.scales > 0
        shares = differences[moving] / self.scales[moving][:, None]
        separations: Array = np.sqrt((shares**2).mean(axis=0))
        return separations


class EnsembleRuns:
    """The runs of an ensemble by number, each the same in any process."""

    def __init__(
        self,
        file: MechanismFile,
        spec: EnsembleSpec,
        times: Array,
        tolerance: float,
        stiff: bool,
        stated: Array | None = None,
    ) -> None:
        """Integrate the motion from the stated start at `times` (n,) [s], unless its states (2k, n)
        are passed.
        """
        self.dynamics, self.spec, self.times = Dynamics(file), spec, times
        self.dynamics.compile()
        self._run = partial(self.dynamics.run, tolerance=tolerance, stiff=stiff)
        self._integrate = partial(self.dynamics.integrate, tolerance=tolerance, stiff=stiff)
        self.stated = (
            self._run(times, state=self.dynamics.find_start()).states if stated is None else stated
        )
        after = times >= spec.since
        self.metric = StateMetric.from_motion(self.dynamics, times[after], self.stated[:, after])

    def __call__(self, number: int) -> EnsembleRun:
        """Return the run of a number from 0 on. Raises ComputationError as `Dynamics.run` does."""
        generator = np.random.default_rng(
            np.random.SeedSequence(self.spec.seed, spawn_key=(number,))
        )
        size = len(self.metric.scales)
        shifts = self.spec.perturbation * generator.uniform(-1.0, 1.0, size)
        run = self._run(self.times, state=self.dynamics.find_start() + shifts * self.metric.scales)
        columns = dict(zip(self.dynamics.names, run.states, strict=True)) | run.results
        with threadpool_limits(1, "blas"):
            growth, reach = self._follow_companion(run, generator.normal(size=size))
        return EnsembleRun(columns, self.metric.measure(run.states, self.stated), growth, reach)

    def _follow_companion(self, run: MotionRun, direction: Array) -> tuple[Array, float]:
        """Return the growth (n - 1,) of a small separation between output times, and its largest
        size.
        """
        metric, growth, reach = self.metric, [], 0.0
        offset, zero = direction * metric.scales, np.zeros((len(direction), 1))
        for number, (start, end) in enumerate(pairwise(run.times)):
            before, after = run.states[:, number], run.states[:, number + 1]
            size = float(metric.measure(offset[:, None], zero)[0])
            companion = self.dynamics.project(start, before + COMPANION / size * offset)
            first = float(metric.measure(companion[:, None], before[:, None])[0])
            offset = self._integrate(np.array([start, end]), state=companion)[0][:, 1] - after
            last = float(metric.measure(offset[:, None], zero)[0])
            growth.append(math.log(last / first))
            reach = max(reach, last)
        return np.array(growth), reach


def compute_ensemble(
    file: MechanismFile,
    until: float,
    points: int,
    spec: EnsembleSpec,
    tolerance: float = 1e-9,
    stiff: bool = False,
    means: Means = AUTO,
    progress: Listener | None = None,
) -> MechanismEnsemble:
    """Return an ensemble of motions to a time [s] at `points` equal steps; `means` do not change
    it.

    Raises InputError for settings that leave no statistics, ComputationError as `Dynamics.run`
    does.
    """
    _check_spec(file, spec, until, points)
    times = np.linspace(0.0, until, points)
    runs = EnsembleRuns(file, spec, times, tolerance, stiff)
    task = Task(
        EnsembleRuns,
        {
            "file": file,
            "spec": spec,
            "times": times,
            "tolerance": tolerance,
            "stiff": stiff,
            "stated": runs.stated,
        },
    )
    phase = ProgressPhase("ensemble", "run", spec.runs, progress)
    computed: list[EnsembleRun] = []
    for run in run_in_order(
        task, range(spec.runs), means, runs, lambda run: run, lambda: phase.report_if_slow(None)
    ):
        phase.advance()
        computed.append(run)
    return _summarise(runs, computed, until)


def _check_spec(file: MechanismFile, spec: EnsembleSpec, until: float, points: int) -> None:
    """Raise InputError for settings that leave no statistics, or too many values."""
    step = until / (points - 1)
    left = until - spec.since
    if left < LEAST_POINTS * step:
        raise InputError(
            f"--since {spec.since:g}: it must be at least {LEAST_POINTS} output times before "
            f"--until"
        )
    if spec.period is not None and not LEAST_POINTS * step <= spec.period <= left:
        raise InputError(
            f"--period {spec.period:g}: it must have at least {LEAST_POINTS} output times, of "
            f"which one is every "
            f"{step:.4g} s, and be at most {left:g} s, the time after --since"
        )
    vectors = file.model.sidecar["vectors"]
    count = spec.runs * points * (len(vectors.get("start_state", ())) + len(vectors["outputs"]))
    if count > MOST_VALUES:
        raise InputError(
            f"--ensemble {spec.runs}: {count} values are too many; lower it, or --points"
        )


def _summarise(
    runs: EnsembleRuns, computed: Sequence[EnsembleRun], until: float
) -> MechanismEnsemble:
    """Return the ensemble of the runs that were computed."""
    spec, times, dynamics = runs.spec, runs.times, runs.dynamics
    vectors = dynamics.formulas.sidecar["vectors"]
    entries = [
        entry
        for entry in (*vectors["start_state"], *vectors["outputs"])
        if all(entry["name"] in run.columns for run in computed)
    ]
    keys = units.display_keys(entries)
    curves = {
        key: np.array([run.columns[name] for run in computed]) / units.unit_factor(key)
        for name, key in keys.items()
    }
    windows = _list_windows(times, spec)
    pieces = {key: _measure_pieces(curve, windows) for key, curve in curves.items()}
    separation = np.array([run.separation for run in computed])
    result = EnsembleResult(
        machine=dynamics.file.name,
        until_s=until,
        since_s=spec.since,
        period_s=spec.period,
        runs=spec.runs,
        periods=len(windows),
        perturbation=spec.perturbation,
        seed=spec.seed,
        quantities={
            key: EnsembleQuantity(
                units.display_unit(key), *(_describe(values) for values in pieces[key].values())
            )
            for key in curves
        },
        separation=_describe_separation(times, separation, computed, spec.since),
        changed_start=list_start_changes(dynamics),
    )
    meanings = {keys[entry["name"]]: entry["meaning"] for entry in entries}
    return MechanismEnsemble(times, curves, meanings, separation, pieces, result)


def _list_windows(times: Array, spec: EnsembleSpec) -> list[Integers]:
    """Return the indices of the output times of each period after `since`, both ends included."""
    resolution = 1e-9 * (times[-1] - times[0])
    length = times[-1] - spec.since if spec.period is None else spec.period
    count = int((times[-1] - spec.since) / length * (1 + 1e-9))
    begins = spec.since + length * np.arange(count)
    return [
        np.flatnonzero((times >= begin - resolution) & (times <= begin + length + resolution))
        for begin in begins
    ]


def _measure_pieces(curve: Array, windows: Sequence[Integers]) -> dict[str, Array]:
    """Return range, variance and peak (runs, periods) of a curve (runs, n) over each window."""
    pieces = [curve[:, window] for window in windows]
    return {
        "range": np.array([np.ptp(piece, axis=1) for piece in pieces]).T,
        "variance": np.array([_measure_variance(piece) for piece in pieces]).T,
        "peak": np.array([np.abs(piece).max(axis=1) for piece in pieces]).T,
    }


def _measure_variance(piece: Array) -> Array:
    """Return the variances (runs,) in time of a piece (runs, m) at equal steps, by the trapezoidal
    rule.
    """
    weights = np.ones(piece.shape[1])
    weights[[0, -1]] = 0.5
    weights /= weights.sum()
    variances: Array = (piece - (piece @ weights)[:, None]) ** 2 @ weights
    return variances


def _describe(values: Array) -> EnsembleStatistic:
    """Return the distribution of values (runs, periods); the error of the mean is that of
    independent runs.
    """
    runs = values.mean(axis=1)
    error = None if len(runs) < 2 else float(runs.std(ddof=1) / math.sqrt(len(runs)))
    low, middle, high = (float(value) for value in np.percentile(values, (5, 50, 95)))
    deviation = float(values.std(ddof=1)) if values.size > 1 else 0.0
    return EnsembleStatistic(float(values.mean()), error, deviation, low, middle, high)


def _describe_separation(
    times: Array, separation: Array, computed: Sequence[EnsembleRun], since: float
) -> EnsembleSeparation:
    """Return when runs part, and the mean rate at which small separations grow after `since`
    [s].
    """
    has_parted = (separation > PARTED).any(axis=1)
    moments = times[(separation[has_parted] > PARTED).argmax(axis=1)]
    counted = times[:-1] >= since
    exponents = np.array([run.growth[counted].sum() for run in computed]) / (
        times[-1] - times[:-1][counted][0]
    )
    is_small = max(run.reach for run in computed) <= MOST_SEPARATION
    error = float(exponents.std(ddof=1) / math.sqrt(len(exponents))) if len(exponents) > 1 else None
    return EnsembleSeparation(
        threshold=PARTED,
        parted_runs=int(has_parted.sum()),
        parted_after_s=_describe(moments[:, None]) if has_parted.any() else None,
        last_median=float(np.median(separation[:, -1])),
        lyapunov_per_s=LyapunovExponent(float(exponents.mean()), error) if is_small else None,
    )
