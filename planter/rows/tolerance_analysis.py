"""Analysis of tolerances: cycles of a machine at random values, their bands, and Sobol' indices of
the variance.
"""

from __future__ import annotations

import hashlib
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from functools import cached_property
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
import scipy
from pydantic import Field, ValidationError

from planter.engine.outputs import SampledOutputs
from planter.errors import ComputationError, InputError
from planter.files.fields import (
    FileSection,
    Positive,
    Problems,
    Real,
    check,
    describe_problems,
    invalid_value_problem,
)
from planter.kernels import Array
from planter.paths import last_part
from planter.progress import Listener
from planter.report import folder
from planter.rows.adapter import MachineAdapter, ResolvedMachine
from planter.rows.job import Recipe, open_store, run_job
from planter.rows.points import (
    HalvedTolerances,
    Kind,
    Saltelli,
    Spread,
    UnitCubePoints,
    draw_points,
)
from planter.rows.results import Band, Share, Tightening, Toleranced, ToleranceFound
from planter.rows.robust import Settings, find_robust
from planter.task import AUTO, Means
from planter.text_files import read_toml


class Tolerance(FileSection):
    """Tolerance of an input about its nominal value: `plus_minus` in its unit, `percent` of it, or
    `from` ... `to`.

    The default distribution is normal with its ends at three standard deviations, or uniform for
    `from` ... `to`.
    """

    plus_minus: Positive | None = None
    percent: Positive | None = None
    low: Annotated[Real | None, Field(alias="from")] = None
    high: Annotated[Real | None, Field(alias="to")] = None
    distribution: Kind | None = None

    @check
    def _check_range(self) -> Problems:
        table = self.model_dump(by_alias=True, exclude_none=True)
        is_range = self.low is not None and self.high is not None
        if sum([self.plus_minus is not None, self.percent is not None, is_range]) != 1 or (
            self.low is None
        ) != (self.high is None):
            yield invalid_value_problem(
                "", table, "it must have either plus_minus, or percent, or from and to"
            )
        elif self.low is not None and self.high is not None and not self.low < self.high:
            yield invalid_value_problem("", table, "it must have from less than to")

    def spread(self, nominal: float) -> Spread:
        """Return the distribution about a nominal value, or between the ends."""
        if self.low is not None and self.high is not None:
            return Spread(self.distribution or "uniform", self.low, self.high)
        half = (
            self.plus_minus
            if self.plus_minus is not None
            else abs(nominal) * (self.percent or 0) / 100
        )
        return Spread(self.distribution or "normal", nominal - half, nominal + half)


class Tolerances(FileSection):
    """Tolerances by input: a name as in `--set`, or a pattern such as "mass.*" for all inputs that
    match it.
    """

    tolerances: Annotated[dict[str, Tolerance], Field(min_length=1)]

    @classmethod
    def load(cls, path: Path) -> Self:
        """Load tolerances from a file.

        Raises InputError, which names file, key, value and the allowed values.
        """
        return cls.read(read_toml(path), str(path))

    @classmethod
    def read(cls, table: Mapping[str, Any], source: str) -> Self:
        """Build tolerances from a table. Raises InputError as `load`."""
        try:
            return cls.model_validate(table)
        except ValidationError as error:
            raise describe_problems(error, source, cls) from None

    def spreads(self, resolved: ResolvedMachine, source: str) -> dict[str, Spread]:
        """Return the distributions of the inputs with a tolerance; of several entries that match,
        the last counts.

        Raises InputError if an entry matches no input, or has no width.
        """
        nominal, spreads = resolved.adapter.nominal(resolved.machine), dict[str, Spread]()
        for name, tolerance in self.tolerances.items():
            for path in self._matches(name, resolved, source):
                spreads[path] = tolerance.spread(nominal[path])
                if not spreads[path].low < spreads[path].high:
                    raise InputError(f"{source}: tolerances.{name}: {path} is 0; use plus_minus")
        return {path: spreads[path] for path in resolved.inputs if path in spreads}

    @staticmethod
    def _matches(name: str, resolved: ResolvedMachine, source: str) -> list[str]:
        """Return the inputs that a name or a pattern matches, by full paths, else by the last parts
        of paths.
        """
        is_pattern = "*" in name or "?" in name
        matches = [path for path in resolved.inputs if is_pattern and fnmatchcase(path, name)]
        matches = matches or [
            path for path in resolved.inputs if is_pattern and fnmatchcase(last_part(path), name)
        ]
        return matches or [resolved.path(name, f"{source}: tolerances.{name}")]


RESAMPLES, CONFIDENCE = 60, 1.96
"""Number of bootstrap samples of an index, and standard deviations to either end of its 95 %
interval.
"""
NO_EFFECT = 1e-9
"""Share of the range of an output below which a change by an input is rounding."""


def compute_bands(
    names: Sequence[str],
    rows: Array,
    nominal: Array,
    slopes: Array,
    spreads: Sequence[Spread],
) -> dict[str, Band]:
    """Return the band of each output from rows (m, k); `nominal` (k,) and slopes (k, n) are those
    at the centre.

    Raises ComputationError if fewer than two rows have a result.
    """
    valid = rows[~np.isnan(rows).any(axis=1)]
    if len(valid) < 2:
        raise ComputationError(
            f"{len(rows) - len(valid)} of {len(rows)} machines have no cycle; narrow the tolerances"
        )
    low, high = np.percentile(valid, (5, 95), axis=0)
    mean, std = valid.mean(axis=0), valid.std(axis=0, ddof=1)
    first = first_order_std(slopes, spreads)
    return {
        name: Band(
            nominal=float(nominal[k]),
            mean=float(mean[k]),
            std=float(std[k]),
            p5=float(low[k]),
            p95=float(high[k]),
            mean_error=float(std[k] / np.sqrt(len(valid))),
            missing=len(rows) - len(valid),
            first_order_std=float(first[k]) if np.isfinite(first[k]) else None,
        )
        for k, name in enumerate(names)
    }


def first_order_std(slopes: Array, spreads: Sequence[Spread]) -> Array:
    """Return standard deviations (k,) to first order, from slopes (k, n) in independent inputs."""
    deviations: Array = np.sqrt((slopes**2) @ np.array([spread.std for spread in spreads]) ** 2)
    return deviations


def compute_indices(
    names: Sequence[str], inputs: Sequence[str], rows: Array, base: int, seed: int
) -> dict[str, dict[str, Share]]:
    """Return the Sobol' indices of each output in each input, from the rows of `Saltelli`.

    Raises ComputationError if a row has no result.
    """
    if np.isnan(rows).any():
        lost = int(np.isnan(rows).any(axis=1).sum())
        raise ComputationError(
            f"{lost} of {len(rows)} machines have no cycle: there are no Sobol' indices"
        )
    f_a, f_b, *mixed = rows.reshape(-1, base, len(names)).transpose(0, 2, 1)
    return {
        name: _shares(inputs, f_a[k], f_b[k], np.array([matrix[k] for matrix in mixed]), seed)
        for k, name in enumerate(names)
    }


def compute_tightening(
    names: Sequence[str], inputs: Sequence[str], rows: Array, bands: Mapping[str, Band]
) -> dict[str, dict[str, Tightening]]:
    """Return what half of each tolerance does to each output, from the rows of `HalvedTolerances`.

    The share by which the standard deviation of the same machines changes applies to that of the
    bands. Machines without a cycle are left out; raises ComputationError if fewer than two are
    left.
    """
    full, *halved = rows.reshape(len(inputs) + 1, -1, len(names))
    tightened: dict[str, dict[str, Tightening]] = {name: {} for name in names}
    for path, part in zip(inputs, halved, strict=True):
        valid = ~np.isnan(full + part).any(axis=1)
        if valid.sum() < 2:
            raise ComputationError(
                f"no machines have a cycle with half the tolerance of {path}; narrow the tolerances"
            )
        before, after = full[valid].std(axis=0), part[valid].std(axis=0)
        changed = np.ptp(full[valid] - part[valid], axis=0) > NO_EFFECT * np.ptp(
            full[valid], axis=0
        )
        shares = np.where(changed, after / np.where(before > 0, before, 1.0), 1.0)
        for name, share in zip(names, shares.tolist(), strict=True):
            tightened[name][path] = Tightening(bands[name].std * share, 100 * (1 - share))
    return tightened


def _shares(
    inputs: Sequence[str], f_a: Array, f_b: Array, f_ab: Array, seed: int
) -> dict[str, Share]:
    """Return the indices of an output from its values on A, B (n,) and the mixed matrices (d, n); 0
    without effect.
    """
    has_effect = np.ptp(f_ab - f_a, axis=1) > NO_EFFECT * np.ptp(f_a)
    shares = dict.fromkeys(inputs, Share(0.0, 0.0, 0.0, 0.0))
    if not has_effect.any():
        return shares
    rng = np.random.default_rng(seed)
    estimates = _indices(f_a, f_b, f_ab[has_effect])
    samples = (rng.integers(len(f_a), size=len(f_a)) for _ in range(RESAMPLES))
    errors = CONFIDENCE * np.std(
        [_indices(f_a[rows], f_b[rows], f_ab[has_effect][:, rows]) for rows in samples], axis=0
    )
    rows = np.vstack([estimates, errors]).T
    names = np.array(inputs)[has_effect].tolist()
    return shares | {name: Share(*map(float, row)) for name, row in zip(names, rows, strict=True)}


def _indices(f_a: Array, f_b: Array, f_ab: Array) -> Array:
    """Return first and total indices, (2, d)."""
    mixed = np.concatenate([f_ab, f_ab[:1]])[:, None]  # SciPy fails on the values of a single input
    result = scipy.stats.sobol_indices(
        func={"f_A": f_a[None], "f_B": f_b[None], "f_AB": mixed}, n=len(f_a)
    )
    return np.array([np.ravel(result.first_order)[:-1], np.ravel(result.total_order)[:-1]])


ROWS, BASE, HALVED = 100_000, 2048, 512
"""Default numbers of random machines, of points of the Sobol' indices, and of machines with halved
tolerances.
"""
MOVING = {"rows": 2000, "base": 128, "halved": 64}
"""These of what moves freely, each of which is integrated: some hundredths of a second a machine."""
ROBUST, MOVING_ROBUST = 128, 32
"""Default numbers of machines of a robust design."""


def list_counts(resolved: ResolvedMachine) -> tuple[dict[str, int], int]:
    """Return the default numbers of a machine, as `ToleranceRequest` names them, and that of the
    machines of its robust design.
    """
    if resolved.built.motion is not None:
        return MOVING, MOVING_ROBUST
    return {"rows": ROWS, "base": BASE, "halved": HALVED}, ROBUST


class ToleranceJob:
    """Job of the outputs of a machine at points within its tolerances."""

    def __init__(
        self,
        module: str,
        machine: Mapping[str, Any],
        choices: Mapping[str, str],
        spreads: Mapping[str, Any],
        outputs: Sequence[str],
        drawn: Mapping[str, int],
        curves: Mapping[str, str] | None = None,
    ) -> None:
        """Build the machine; `curves`, hashes of files that outputs need, distinguish jobs with
        other files.
        """
        distributions = {name: Spread(*entry) for name, entry in spreads.items()}
        ends = {name: spread.ends for name, spread in distributions.items()}
        adapter: MachineAdapter = import_module(module).ADAPTER
        self.subject = adapter.subject(machine, choices, ends, outputs)
        kinds: dict[str, Callable[..., UnitCubePoints]] = {
            "rows": draw_points,
            "base": Saltelli,
            "machines": HalvedTolerances,
        }
        (kind,) = kinds.keys() & drawn.keys()
        self.points = kinds[kind](tuple(distributions.values()), **drawn)
        self.rows, self.width = self.points.rows, len(outputs)

    def chunk(self, start: int, stop: int, threads: int) -> Array:
        """Return the outputs at the points from `start` to `stop`, (stop - start, width)."""
        return self.subject.evaluated(self.points.block(start, stop), threads)


@dataclass(frozen=True)
class ToleranceRequest:
    """Request of an analysis: outputs, number of random machines, points of the indices (a power of
    2, or 0), a seed.

    `halved` is the number of machines whose tolerances are halved one by one, 0 for none.
    `robust` are the settings of the robust design, None for an analysis without it.
    """

    outputs: Sequence[str] = ()
    rows: int = ROWS
    base: int = BASE
    seed: int = 0
    halved: int = HALVED
    robust: Settings | None = field(default_factory=Settings)


@dataclass(frozen=True)
class ToleranceCase:
    """A machine with the distributions of its inputs, and the outputs to evaluate."""

    resolved: ResolvedMachine
    choices: Mapping[str, str]
    spreads: Mapping[str, Spread]
    outputs: Sequence[str]

    @cached_property
    def subject(self) -> SampledOutputs:
        """The machine, built for inputs between the ends of their tolerances."""
        adapter: MachineAdapter = self.resolved.adapter
        ends = {name: spread.ends for name, spread in self.spreads.items()}
        frozen = adapter.frozen(self.resolved.machine)
        return adapter.subject(frozen, self.choices, ends, self.outputs)

    @property
    def centre(self) -> Array:
        """Means of the inputs, (n,)."""
        return np.array([spread.centre for spread in self.spreads.values()])

    def build_recipe(self, sampling: Mapping[str, int]) -> Recipe:
        """Return the recipe of the rows; `sampling` is `rows` and `seed`, `base` and `seed` for
        indices, or `machines` and `seed` for halved tolerances.
        """
        resolved = self.resolved
        return Recipe(
            f"{__name__}:{ToleranceJob.__name__}",
            {
                "module": resolved.module,
                "machine": resolved.adapter.frozen(resolved.machine),
                "choices": dict(self.choices),
                "spreads": {name: [s.kind, s.low, s.high] for name, s in self.spreads.items()},
                "outputs": list(self.outputs),
                "drawn": sampling,
                **resolved.hash_curves(self.outputs),
            },
        )


@dataclass(frozen=True)
class ToleranceAnalysis:
    """Analysis of a case: outputs (m, k) of the random machines, and the result."""

    case: ToleranceCase
    rows: Array
    result: ToleranceFound


def analyse_tolerances(
    resolved: ResolvedMachine,
    choices: Mapping[str, str],
    tolerances: Tolerances,
    source: str,
    request: ToleranceRequest,
    out: Path | None = None,
    means: Means = AUTO,
    progress: Listener | None = None,
) -> ToleranceAnalysis:
    """Compute bands, indices and the robust design of a machine; `source` is the file of its
    tolerances, for messages.

    Rows are stored in the folder `out`, if any. Raises InputError if tolerances or outputs do not
    fit the machine, ComputationError if it has no cycles, and Interrupted on Ctrl-C, after which
    the same call resumes.
    """
    if request.base & (request.base - 1):
        raise InputError(f"--indices = {request.base}: the number must be a power of 2, or 0")
    started, adapter = time.perf_counter(), resolved.adapter
    names = resolved.resolve_outputs(request.outputs, "--output")
    case = ToleranceCase(resolved, choices, tolerances.spreads(resolved, source), names)
    inputs, digests = list(case.spreads), list[str]()

    def compute_rows(name: str, count: int, **sampling: int) -> Array:
        """Return `count` rows of outputs at the points of `sampling`, stored by a name."""
        recipe = case.build_recipe({**sampling, "seed": request.seed})
        path = None if out is None else folder.output_folder(out) / f"{name}.sqlite"
        with open_store(path, recipe.question, count, len(names)) as store:
            run_job(recipe, store, means, progress)
            digests.append(store.digest())
            return np.vstack(list(store.blocks()))

    rows = compute_rows("bands", request.rows, rows=request.rows)
    nominal, slopes = case.subject.slopes(case.centre)
    bands = compute_bands(names, rows, nominal, slopes, list(case.spreads.values()))
    index_rows = request.base * (len(inputs) + 2)
    sobol, tightened = dict[str, dict[str, Share]](), dict[str, dict[str, Tightening]]()
    if request.base:
        mixed = compute_rows("indices", index_rows, base=request.base)
        sobol = compute_indices(names, inputs, mixed, request.base, request.seed)
    halved_rows = request.halved * (len(inputs) + 1)
    if request.halved:
        halved = compute_rows("halved", halved_rows, machines=request.halved)
        tightened = compute_tightening(names, inputs, halved, bands)
    robust = None
    if request.robust is not None:
        goal = adapter.build_robust(resolved.machine, choices, case.spreads, request.robust)
        robust = None if goal is None else find_robust(goal, request.robust, progress)
    digest = digests[0]
    for other in digests[1:]:
        digest = hashlib.sha256(f"{digest}{other}".encode()).hexdigest()
    result = ToleranceFound(
        machine=resolved.machine.name,
        choices=dict(choices),
        seed=request.seed,
        rows=request.rows,
        inputs=[Toleranced(name, s.kind, s.low, s.high, s.std) for name, s in case.spreads.items()],
        index_rows=index_rows,
        outputs=bands,
        sobol=sobol,
        seconds=time.perf_counter() - started,
        hash=digest,
        robust=robust,
        tightened_rows=halved_rows,
        tightened=tightened,
    )
    return ToleranceAnalysis(case, rows, result)


def default_tolerances(resolved: ResolvedMachine) -> Tolerances:
    """Return the default tolerances of a machine. Raises InputError if its kind has no defaults."""
    table = resolved.adapter.tolerances(resolved.machine)
    if not table:
        raise InputError(
            f"{resolved.source}: this machine has no default tolerances; add --tolerances FILE"
        )
    return Tolerances.read({"tolerances": table}, f"{resolved.source}: default tolerances")
