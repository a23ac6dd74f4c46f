"""Main effects of an orthogonal or any other design: range analysis, analysis of variance, additive prediction.

Montgomery, Design and Analysis of Experiments, chapters 3 and 8.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from planter.clutch.field.trial import Factor, FieldResponse, Trial
from planter.clutch.results.field import Effect, LevelMeans, Residual, Total
from planter.errors import InputError

if TYPE_CHECKING:
    from planter.kernels import Array

ROUNDING = 100 * np.finfo(float).eps
"""Residuals below this share of the response are rounding: there is no error to compare effects with."""
LARGEST = 5_000_000
"""Runs times effects that are analysed at most."""


def is_orthogonal(factors: Sequence[Factor]) -> bool:
    """Return whether all levels of a factor occur equally often, and so do all pairs of levels of two factors."""
    single = (np.bincount(factor.codes) for factor in factors)
    pairs = (
        np.bincount(a.codes * len(b.levels) + b.codes, minlength=len(a.levels) * len(b.levels))
        for a, b in itertools.combinations(factors, 2)
    )
    return all(np.ptp(counts) == 0 for counts in itertools.chain(single, pairs))


@dataclass(frozen=True)
class Effects:
    """Main effects of one response: mean of all combinations of levels, and what each level adds to it."""

    mean: float
    levels: tuple[Array, ...]

    def predict(self) -> Array:
        """Return the additive prediction for every combination of levels, the last factor's changing fastest."""
        total = np.array([self.mean])
        for level in self.levels:
            total = np.add.outer(total, level)
        return total.ravel()


class MainEffectsModel:
    """Main effects of all factors of a trial, each coded so that the effects of its levels sum to zero.

    Raises InputError, naming the factors, for a design with fewer runs than effects, or one in which effects cannot
    be separated.
    """

    def __init__(self, trial: Trial) -> None:
        _check_size(trial)
        self.trial = trial
        self.blocks = [_coded(factor) for factor in trial.factors]
        self.matrix = self._columns(range(len(self.blocks)))
        effects = self.matrix.shape[1]
        if np.linalg.matrix_rank(self.matrix) < effects:
            raise InputError(
                f"{trial.source}: the effects of {' and '.join(self._mixed())} cannot be separated by these runs, "
                f"but the levels of factors must vary independently"
            )
        self.freedom = trial.runs - effects

    def effects(self, response: FieldResponse) -> Effects:
        """Return least-squares effects; in an orthogonal design, level means less the mean of all runs."""
        middle, size = _scaled(response.values)
        fit = fit_least_squares((response.values - middle) / size, self.matrix)
        ends = np.cumsum([1, *(block.shape[1] for block in self.blocks)])
        parts = [fit.parameters[start:end] for start, end in itertools.pairwise(ends)]
        levels = tuple(size * np.append(part, -part.sum()) for part in parts)
        return Effects(float(middle + size * fit.parameters[0]), levels)

    def anova(self, response: FieldResponse) -> dict[str, Effect | Residual | Total]:
        """Return sums of squares of each factor over all others (type II), of the error and of all runs.

        F and p are None if the error has no degrees of freedom, or is rounding.
        """
        from scipy import stats

        middle, size = _scaled(response.values)
        scaled = (response.values - middle) / size
        rest = fit_least_squares(scaled, self.matrix).residual_squares
        noise = rest / self.freedom if self.freedom else None
        if noise is not None and rest <= ROUNDING**2 * np.sum((response.values / size) ** 2):
            noise = None
        table: dict[str, Effect | Residual | Total] = {}
        for index, (factor, block) in enumerate(self._pairs()):
            reduced = self._columns(i for i in range(len(self.blocks)) if i != index)
            ss, df = max(fit_least_squares(scaled, reduced).residual_squares - rest, 0.0), block.shape[1]
            ratio = None if noise is None else ss / df / noise
            p = None if ratio is None else float(stats.f.sf(ratio, df, self.freedom))
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
        means = [float(response.values[factor.codes == code].mean()) for code in range(len(factor.levels))]
        means_by_factor[factor.name] = LevelMeans(means, max(means) - min(means))
    return means_by_factor


def index_of_minimum(values: Array) -> int:
    """Return the index of the first value that is the smallest up to rounding."""
    slack = ROUNDING * float(np.max(np.abs(values)))
    return int(np.argmax(values <= values.min() + slack))


def _check_size(trial: Trial) -> None:
    effects = 1 + sum(len(factor.levels) - 1 for factor in trial.factors)
    if trial.runs < effects:
        counted = ", ".join(f"{len(factor.levels) - 1} of {factor.name}" for factor in trial.factors)
        raise InputError(
            f"{trial.source}: there are {trial.runs} runs for {effects} effects (the mean, {counted}), "
            f"there must be at least as many runs (is a column no factor? see --response, --blank and --ignore)"
        )
    if trial.runs * effects > LARGEST:
        raise InputError(
            f"{trial.source}: {trial.runs} runs times {effects} effects are too many, there must be at most {LARGEST}"
        )


def _coded(factor: Factor) -> Array:
    """Columns (n, levels - 1) that sum to zero over the levels."""
    free = len(factor.levels) - 1
    return np.vstack([np.eye(free), -np.ones(free)])[factor.codes]


def _scaled(values: Array) -> tuple[float, float]:
    """Mean of a response and its largest distance from there: without them squares neither over- nor underflow."""
    middle = float(np.mean(values))
    return middle, float(np.max(np.abs(values - middle)))


@dataclass(frozen=True)
class LeastSquaresFit:
    """Parameters (p,) of a linear model and the sum of its squared residuals."""

    parameters: Array
    residual_squares: float


def fit_least_squares(values: Array, columns: Array) -> LeastSquaresFit:
    """Return the fit of values (n,) by columns (n, p) of full rank, by orthogonal decomposition (LAPACK gelsd)."""
    parameters = np.asarray(np.linalg.lstsq(columns, values, rcond=None)[0], dtype=float)
    residuals = values - columns @ parameters
    return LeastSquaresFit(parameters, float(residuals @ residuals))
