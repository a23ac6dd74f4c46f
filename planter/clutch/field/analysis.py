"""Analysis of variance and of ranges of a field test, predictions, and the comparison of
clutches.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy

from planter.clutch.field.trial import Factor, FieldResponse, Trial
from planter.clutch.results import Compared, Effect, LevelMeans, Residual, Total
from planter.errors import InputError
from planter.files import csv_rows

if TYPE_CHECKING:
    from planter.kernels import Array

ROUNDING = 100 * np.finfo(float).eps
"""Residuals below this share of the response are rounding: there is no error to compare effects
with.
"""
LARGEST = 5_000_000
"""Runs times effects that are analysed at most."""


def is_orthogonal(factors: Sequence[Factor]) -> bool:
    """Return whether all levels of a factor occur equally often, and so do all pairs of levels of
    two factors.
    """
    single = (np.bincount(factor.codes) for factor in factors)
    pairs = (
        np.bincount(a.codes * len(b.levels) + b.codes, minlength=len(a.levels) * len(b.levels))
        for a, b in itertools.combinations(factors, 2)
    )
    return all(np.ptp(counts) == 0 for counts in itertools.chain(single, pairs))


@dataclass(frozen=True)
class Effects:
    """Main effects of one response: mean of all combinations of levels, and what each level adds to
    it.
    """

    mean: float
    levels: tuple[Array, ...]

    def predict(self) -> Array:
        """Return the additive prediction for every combination of levels, the last factor's
        changing fastest.
        """
        total = np.array([self.mean])
        for level in self.levels:
            total = np.add.outer(total, level)
        return total.ravel()


class MainEffectsModel:
    """Main effects of all factors of a trial, each coded so that the effects of its levels sum to
    zero.

    Raises InputError, naming the factors, for a design with fewer runs than effects, or one in
    which effects cannot be separated.
    """

    def __init__(self, trial: Trial) -> None:
        _check_size(trial)
        self.trial = trial
        self.blocks = [_coded(factor) for factor in trial.factors]
        self.matrix = self._columns(range(len(self.blocks)))
        effects = self.matrix.shape[1]
        if np.linalg.matrix_rank(self.matrix) < effects:
            raise InputError(
                f"{trial.source}: the effects of {' and '.join(self._mixed())} cannot be "
                f"separated by these runs, "
                f"but the levels of factors must vary independently"
            )
        self.freedom = trial.runs - effects

    def effects(self, response: FieldResponse) -> Effects:
        """Return least-squares effects; in an orthogonal design, level means less the mean of all
        runs.
        """
        middle, size = _scaled(response.values)
        fit = fit_least_squares((response.values - middle) / size, self.matrix)
        ends = np.cumsum([1, *(block.shape[1] for block in self.blocks)])
        parts = [fit.parameters[start:end] for start, end in itertools.pairwise(ends)]
        levels = tuple(size * np.append(part, -part.sum()) for part in parts)
        return Effects(float(middle + size * fit.parameters[0]), levels)

    def anova(self, response: FieldResponse) -> dict[str, Effect | Residual | Total]:
        """Return sums of squares of each factor over all others (type II), of the error and of all
        runs.

        F and p are None if the error has no degrees of freedom, or is rounding.
        """
        middle, size = _scaled(response.values)
        scaled = (response.values - middle) / size
        rest = fit_least_squares(scaled, self.matrix).residual_squares
        noise = rest / self.freedom if self.freedom else None
        if noise is not None and rest <= ROUNDING**2 * np.sum((response.values / size) ** 2):
            noise = None
        table: dict[str, Effect | Residual | Total] = {}
        for index, (factor, block) in enumerate(self._pairs()):
            reduced = self._columns(i for i in range(len(self.blocks)) if i != index)
            ss, df = (
                max(fit_least_squares(scaled, reduced).residual_squares - rest, 0.0),
                block.shape[1],
            )
            ratio = None if noise is None else ss / df / noise
            p = None if ratio is None else float(scipy.stats.f.sf(ratio, df, self.freedom))
            table[factor.name] = Effect(ss * size**2, df, ss * size**2 / df, ratio, p)
        ms = rest * size**2 / self.freedom if self.freedom else None
        table["error"] = Residual(rest * size**2, self.freedom, ms)
        table["total"] = Total(float(scaled @ scaled) * size**2, self.trial.runs - 1)
        return table

    def _pairs(self) -> Iterator[tuple[Factor, Array]]:
        return zip(self.trial.factors, self.blocks, strict=True)

    def _columns(self, indices: Any) -> Array:
        return np.hstack([np.ones((self.trial.runs, 1)), *(self.blocks[i] for i in indices)])

    def _mixed(self) -> list[str]:
        """Factors that lose nothing, or less than their effects, when they are left out."""
        rank = np.linalg.matrix_rank(self.matrix)
        names = []
        for index, (factor, block) in enumerate(self._pairs()):
            reduced = self._columns(i for i in range(len(self.blocks)) if i != index)
            if rank - np.linalg.matrix_rank(reduced) < block.shape[1]:
                names.append(factor.name)
        return names


def range_analysis(trial: Trial, response: FieldResponse) -> dict[str, LevelMeans]:
    """Return the means of the runs at each level of a factor, and their range."""
    means_by_factor = {}
    for factor in trial.factors:
        means = [
            float(response.values[factor.codes == code].mean())
            for code in range(len(factor.levels))
        ]
        means_by_factor[factor.name] = LevelMeans(means, max(means) - min(means))
    return means_by_factor


def index_of_minimum(values: Array) -> int:
    """Return the index of the first value that is the smallest up to rounding."""
    slack = ROUNDING * float(np.max(np.abs(values)))
    return int(np.argmax(values <= values.min() + slack))


def _check_size(trial: Trial) -> None:
    effects = 1 + sum(len(factor.levels) - 1 for factor in trial.factors)
    if trial.runs < effects:
        counted = ", ".join(
            f"{len(factor.levels) - 1} of {factor.name}" for factor in trial.factors
        )
        raise InputError(
            f"{trial.source}: there are {trial.runs} runs for {effects} effects (the mean, "
            f"{counted}), "
            f"there must be at least as many runs (is a column no factor? see --response, --blank "
            f"and --ignore)"
        )
    if trial.runs * effects > LARGEST:
        raise InputError(
            f"{trial.source}: {trial.runs} runs times {effects} effects are too many, there must "
            f"be at most {LARGEST}"
        )


def _coded(factor: Factor) -> Array:
    """Columns (n, levels - 1) that sum to zero over the levels."""
    free = len(factor.levels) - 1
    return np.vstack([np.eye(free), -np.ones(free)])[factor.codes]


def _scaled(values: Array) -> tuple[float, float]:
    """Mean of a response and its largest distance from there: without them squares neither over-
    nor underflow.
    """
    middle = float(np.mean(values))
    return middle, float(np.max(np.abs(values - middle)))


@dataclass(frozen=True)
class LeastSquaresFit:
    """Parameters (p,) of a linear model and the sum of its squared residuals."""

    parameters: Array
    residual_squares: float


def fit_least_squares(values: Array, columns: Array) -> LeastSquaresFit:
    """Return the fit of values (n,) by columns (n, p) of full rank, by orthogonal decomposition
    (LAPACK gelsd).
    """
    parameters = np.asarray(np.linalg.lstsq(columns, values, rcond=None)[0], dtype=float)
    residuals = values - columns @ parameters
    return LeastSquaresFit(parameters, float(residuals @ residuals))


MOST_CLUTCHES = 20
HEADER = ("clutch", "speed_m_s", "measure", "mean", "sd", "n")


@dataclass(frozen=True)
class Sample:
    """Summary of the measurements of one clutch at one speed; `sd` is the sample standard
    deviation.
    """

    clutch: str
    speed_m_s: float
    measure: str
    mean: float
    sd: float
    n: int


def read_samples(text: str, source: str) -> list[Sample]:
    """Return the samples of a CSV text with the columns of `HEADER`.

    Raises InputError, naming line and column.
    """
    table = csv_rows.read_table(text, source, HEADER)
    _check(table)
    numbers = zip(*(table.numbers(name) for name in ("speed_m_s", "mean", "sd", "n")), strict=True)
    samples = [
        Sample(clutch, speed, measure, mean, sd, int(n))
        for clutch, measure, (speed, mean, sd, n) in zip(
            table.column("clutch"), table.column("measure"), numbers, strict=True
        )
    ]
    _check_distinct(table, samples)
    return samples


def _check(table: csv_rows.CsvTable) -> None:
    for row, sd in enumerate(table.numbers("sd")):
        if sd < 0:
            raise InputError(f"{table.place(row, 'sd')}: {sd:g}: it must not be negative")
    for row, n in enumerate(table.numbers("n")):
        if n < 2 or not n.is_integer():
            raise InputError(f"{table.place(row, 'n')}: {n:g}: it must be a whole number from 2 on")


def _check_distinct(table: csv_rows.CsvTable, samples: Sequence[Sample]) -> None:
    seen: dict[tuple[str, float, str], int] = {}
    for sample, line in zip(samples, table.lines, strict=True):
        before = seen.setdefault((sample.clutch, sample.speed_m_s, sample.measure), line)
        if before != line:
            raise InputError(
                f"{table.source}: line {line} gives {sample.measure} of {sample.clutch} at "
                f"{sample.speed_m_s:g} m/s "
                f"again after line {before}, but each must be given once"
            )
    clutches = len({sample.clutch for sample in samples})
    if not 2 <= clutches <= MOST_CLUTCHES:
        raise InputError(
            f"{table.source}: column clutch names {clutches}, there must be 2 to {MOST_CLUTCHES}"
        )


def compare_samples(samples: Sequence[Sample]) -> tuple[list[Compared], list[Compared]]:
    """Return every pair of clutches at each speed and measure of both: the first two clutches, then
    all others.

    `reduction_percent` is (reference - clutch) / reference of the means, None for a reference of
    zero; `p_value` is that of Welch's two-sided test, None where neither clutch scatters; `p_holm`
    is the same by Holm's procedure over all pairs: what is called significant by it holds for all
    of them together.
    """
    clutches = list(dict.fromkeys(sample.clutch for sample in samples))
    at = {(sample.clutch, sample.speed_m_s, sample.measure): sample for sample in samples}
    pairings = [
        (sample, at.get((second, sample.speed_m_s, sample.measure)))
        for first, second in itertools.combinations(clutches, 2)
        for sample in samples
        if sample.clutch == first
    ]
    pairs = _adjusted([_pair(new, reference) for new, reference in pairings if reference])
    main = [pair for pair in pairs if (pair.clutch, pair.reference) == tuple(clutches[:2])]
    return main, pairs[len(main) :]


def _pair(new: Sample, reference: Sample) -> Compared:
    with np.errstate(all="ignore"):
        reduction = float(100 * (1 - np.float64(new.mean) / reference.mean))
    return Compared(
        speed_m_s=new.speed_m_s,
        measure=new.measure,
        clutch=new.clutch,
        reference=reference.clutch,
        difference=new.mean - reference.mean,
        reduction_percent=reduction if math.isfinite(reduction) else None,
        p_value=welch_probability(new, reference),
        p_holm=None,
    )


def welch_probability(a: Sample, b: Sample) -> float | None:
    """Return the p-value of equal means with unequal variances (Welch 1947), or None if neither
    clutch scatters.
    """
    scale = max(a.sd, b.sd)
    if scale == 0:
        return None
    gap = (a.mean - b.mean) / scale
    test = scipy.stats.ttest_ind_from_stats(
        gap, a.sd / scale, a.n, 0.0, b.sd / scale, b.n, equal_var=False
    )
    return float(test.pvalue)


def _adjusted(pairs: Sequence[Compared]) -> list[Compared]:
    """The pairs with their chances by Holm's procedure."""
    adjusted = iter(adjust_by_holm([pair.p_value for pair in pairs if pair.p_value is not None]))
    return [
        pair if pair.p_value is None else replace(pair, p_holm=next(adjusted)) for pair in pairs
    ]


def adjust_by_holm(probabilities: Sequence[float]) -> list[float]:
    """Return probabilities adjusted for their number by the step-down procedure of Holm (1979), in
    the same order.

    The k-th smallest of m is multiplied by m - k + 1, is at least the adjusted one before it, and
    at most 1.

    >>> adjust_by_holm([0.01, 0.04, 0.03])
    [0.03, 0.06, 0.06]
    """
    adjusted, largest = [0.0] * len(probabilities), 0.0
    for rank, index in enumerate(sorted(range(len(probabilities)), key=probabilities.__getitem__)):
        largest = max(largest, min(1.0, (len(probabilities) - rank) * probabilities[index]))
        adjusted[index] = largest
    return adjusted
