"""Field tests by orthogonal arrays: range analysis, analysis of variance, best levels, comparison.

A field test is a CSV file: lines that start with `#`, a header, then a row for each run. `run`
counts the runs; `blank`, `empty` or `error`, with a number behind it or without, is a column of the
array that no factor is assigned to; `Y`, or `Y` followed by anything but a letter (`Y1`, `Y2_cm`),
is a response; every other column is a factor, whose levels are all numbers or all words. Comments
`# factor A: axial angle / deg` and `# response Y1: lag / cm` name columns on figures.

Levels of factors occur equally often, and so do all pairs of levels of two factors: then sums of
squares of all types agree. The prediction adds main effects; the error is what they leave (blank
columns, repetitions). The comparison is Welch's test of two means, from a second CSV file.

Sources: Montgomery, Design and Analysis of Experiments, chapters 3 and 8; Welch, Biometrika 34
(1947) 28; Shi et al. 2021, section 4.
"""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from planter.errors import InputError
from planter.files import csv_rows, examples
from planter.kernels import Array
from planter.papers.clutch.results import (
    ComparedClutches,
    Effect,
    FieldPlan,
    FieldTest,
    Level,
    LevelMeans,
    PredictedRun,
    Total,
)

PAPER, PAPER_COMPARISON = "shi2021-field", "shi2021-comparison"
SAMPLE_HEADER = ("clutch", "speed_m_s", "measure", "mean", "sd", "n")
ROUNDING = 1e-12
"""Share of the largest loss, or of the total variation, below which a difference is rounding."""
MOST_COMBINATIONS = 20_000
ALLOWED = "larger, smaller, zero, or a number for a target value"
ARRAYS = {"L4": (2, 2), "L8": (2, 3), "L9": (3, 2), "L25": (5, 2), "L27": (3, 3)}
"""Arrays with p^k runs over the integers modulo a prime p: name, p, k."""
_RESPONSE = re.compile(r"[Yy]($|[^A-Za-z])")
_BLANK = re.compile(r"(blank|empty|error)[\s_]*\d*", re.IGNORECASE)
_LABEL = re.compile(r"(?:factor|response)\s+([^:]+?)\s*:\s*([^=]*[^=\s]).*")


@dataclass(frozen=True)
class Factor:
    """A column of levels: `codes` (n,) count from 0 into `levels`."""

    levels: tuple[Level, ...]
    codes: NDArray[np.intp]


@dataclass(frozen=True)
class Trial:
    """Runs of a field test: factors and responses (n,) by name, and what columns mean."""

    source: str
    factors: Mapping[str, Factor]
    responses: Mapping[str, Array]
    labels: Mapping[str, str]


@dataclass(frozen=True)
class Sample:
    """Measurements of a clutch at a speed: mean, sample standard deviation and number."""

    clutch: str
    speed_m_s: float
    measure: str
    mean: float
    sd: float
    n: int


@dataclass(frozen=True)
class FieldEvaluation:
    """The runs, the samples that are compared, and the result as the command gives it."""

    trial: Trial
    samples: Sequence[Sample]
    result: FieldTest


def evaluate_field(
    source: str = PAPER, goals: Mapping[str, str] | None = None, comparison: str | None = None
) -> FieldEvaluation:
    """Return the evaluation of the field test in a CSV file, or the built-in one of that name.

    The paper's own responses are lags, whose goal is zero by default; its runs bring the file of
    its `comparison`. Raises InputError for data that cannot be evaluated, and for responses without
    a goal.
    """
    trial = read_trial(examples.read_source(source, "clutch", ".csv"), source)
    stated = dict(goals or {})
    if source == PAPER:
        stated = dict.fromkeys(trial.responses, "zero") | stated
        comparison = comparison or PAPER_COMPARISON
    if stated.keys() != trial.responses.keys():
        options = " ".join(f"--goal {name}=larger" for name in trial.responses)
        raise InputError(f"{source}: each response needs one goal, as in {options} ({ALLOWED})")
    samples: list[Sample] = []
    if comparison:
        samples = read_samples(examples.read_source(comparison, "clutch", ".csv"), comparison)
    return FieldEvaluation(trial, samples, evaluate_trial(trial, stated, samples))


def read_trial(text: str, source: str) -> Trial:
    """Return the runs in a CSV text. Raises InputError, naming the column, for any other text."""
    table = csv_rows.read_table(text, source)
    responses = {
        name: np.array(table.numbers(name)) for name in table.header if _RESPONSE.match(name)
    }
    columns = [name for name in table.header if name not in responses and name.lower() != "run"]
    factors = {name: _read_factor(table, name) for name in columns if not _BLANK.fullmatch(name)}
    if not responses or not factors:
        raise InputError(
            f"{source}: it needs a column Y, Y1, ... for a response and one for a factor, "
            f"it has {', '.join(table.header)}"
        )
    for name, values in responses.items():
        if np.ptp(values) == 0:
            raise InputError(f"{source}: column {name}: a response must vary to be analysed")
    _check_balance(factors, source)
    matches = (_LABEL.fullmatch(comment) for _, comment in table.comments)
    labels = {match[1]: match[2] for match in matches if match}
    return Trial(source, factors, responses, labels)


def _read_factor(table: csv_rows.CsvTable, name: str) -> Factor:
    cells: Sequence[Level] = table.column(name)
    if any(csv_rows.parse_number(str(cell)) is not None for cell in cells):
        cells = [int(x) if x.is_integer() else x for x in table.numbers(name)]
        levels = sorted(set(cells), key=float)
    else:
        levels = list(dict.fromkeys(cells))
    if len(levels) < 2:
        raise InputError(f"{table.source}: column {name}: a factor needs at least two levels")
    return Factor(tuple(levels), np.array([levels.index(cell) for cell in cells]))


def _check_balance(factors: Mapping[str, Factor], source: str) -> None:
    """Raise InputError unless all levels, and all pairs of levels, occur equally often."""
    for a, b in itertools.combinations_with_replacement(factors, 2):
        first, second = factors[a], factors[b]
        counts = np.zeros((len(first.levels), len(second.levels)))
        np.add.at(counts, (first.codes, second.codes), 1)
        if np.ptp(np.diag(counts) if a == b else counts) > 0:
            raise InputError(
                f"{source}: levels of {a} and {b} must occur equally often together (an orthogonal "
                f"array); a column that is no factor must be called blank"
            )
    if math.prod(len(factor.levels) for factor in factors.values()) > MOST_COMBINATIONS:
        raise InputError(f"{source}: there may be at most {MOST_COMBINATIONS} combinations")


def evaluate_trial(
    trial: Trial, goals: Mapping[str, str], samples: Sequence[Sample] = ()
) -> FieldTest:
    """Return the analyses of a field test. Raises InputError for an unknown goal."""
    levels = [factor.levels for factor in trial.factors.values()]
    combinations = list(itertools.product(*levels))
    ranges, tables, predicted = {}, {}, {}
    for name, values in trial.responses.items():
        means = {key: _average_levels(factor, values) for key, factor in trial.factors.items()}
        effects = [mean - values.mean() for mean in means.values()]
        ranges[name] = {
            key: LevelMeans(mean.tolist(), float(np.ptp(mean))) for key, mean in means.items()
        }
        tables[name] = analyse_variance(trial, values, effects)
        total = np.array([values.mean()])
        for effect in effects:
            total = np.add.outer(total, effect)
        predicted[name] = total.ravel()
    parsed = {name: parse_goal(name, goals[name]) for name in trial.responses}
    losses = {name: find_losses(parsed[name], values) for name, values in predicted.items()}
    ranks = [rank_losses(loss) for loss in losses.values()]
    # Equal mean ranks go by the worst rank.
    order = np.lexsort((np.max(ranks, axis=0), np.mean(ranks, axis=0)))
    best = {name: int(rank.argmin()) for name, rank in zip(losses, ranks, strict=True)}
    best["both"] = int(order[0])
    rows = [
        PredictedRun(list(chosen), dict(zip(predicted, map(float, means), strict=True)))
        for chosen, *means in zip(combinations, *predicted.values(), strict=True)
    ]
    return FieldTest(
        source=trial.source,
        runs=len(next(iter(trial.responses.values()))),
        goals=parsed,
        range=ranges,
        anova=tables,
        best={name: list(combinations[index]) for name, index in best.items()},
        prediction=rows,
        comparison=compare_samples(samples),
    )


def _average_levels(factor: Factor, values: Array) -> Array:
    means = [values[factor.codes == code].mean() for code in range(len(factor.levels))]
    return np.array(means)


def analyse_variance(
    trial: Trial, values: Array, effects: Sequence[Array]
) -> dict[str, Effect | Total]:
    """Return sums of squares of each factor, of the error and of all runs.

    F and p are None if the error has no degrees of freedom, or is rounding.
    """
    residuals, runs = values - values.mean(), len(values)
    total, freedom = Total(float(residuals @ residuals), runs - 1), runs - 1
    for factor, effect in zip(trial.factors.values(), effects, strict=True):
        residuals = residuals - effect[factor.codes]
        freedom -= len(effect) - 1
    rest = float(residuals @ residuals)
    noise = rest / freedom if freedom else None
    is_exact = noise is None or rest <= ROUNDING**2 * total.ss
    table: dict[str, Effect | Total] = {}
    for (name, factor), effect in zip(trial.factors.items(), effects, strict=True):
        ss, df = float(np.sum(effect[factor.codes] ** 2)), len(effect) - 1
        ratio = None if is_exact or noise is None else ss / df / noise
        p = None if ratio is None else float(scipy.stats.f.sf(ratio, df, freedom))
        table[name] = Effect(ss, df, ss / df, ratio, p)
    return table | {"error": Effect(rest, freedom, noise, None, None), "total": total}


def parse_goal(name: str, text: str) -> str:
    """Return a goal as results have it: `larger`, `smaller`, `nearest 0` or `target V`."""
    plain = text.strip().lower()
    if plain in ("larger", "smaller"):
        return plain
    value = "0" if plain == "zero" else plain
    if not csv_rows.is_finite_number(value):
        raise InputError(f"--goal {name}={csv_rows.shorten_text(text)}: a goal must be {ALLOWED}")
    return f"target {float(value):.10g}" if float(value) else "nearest 0"


def find_losses(goal: str, values: Array) -> Array:
    """Return the distances of values (n,) from a goal: less is better."""
    word, _, target = goal.partition(" ")
    losses = {"larger": -values, "smaller": values}
    return losses[word] if word in losses else np.abs(values - float(target))


def rank_losses(losses: Array) -> Array:
    """Return ranks (n,) from 1 for the smallest; equal losses, up to rounding, share their mean."""
    step = ROUNDING * float(np.max(np.abs(losses)))
    ranks: Array = scipy.stats.rankdata(np.round(losses / step) if step else losses)
    return ranks


def read_samples(text: str, source: str) -> list[Sample]:
    """Return the samples of a CSV text. Raises InputError, naming line and column."""
    table = csv_rows.read_table(text, source, SAMPLE_HEADER)
    columns = [table.numbers(name) for name in ("speed_m_s", "mean", "sd", "n")]
    samples = []
    for row, (speed, mean, sd, n) in enumerate(zip(*columns, strict=True)):
        if sd < 0:
            raise InputError(f"{table.place(row, 'sd')}: {sd:g}: it must not be negative")
        if n < 2 or not n.is_integer():
            raise InputError(f"{table.place(row, 'n')}: {n:g}: it must be a whole number from 2 on")
        clutch, measure = table.column("clutch")[row], table.column("measure")[row]
        samples.append(Sample(clutch, speed, measure, mean, sd, int(n)))
    return samples


def compare_samples(samples: Sequence[Sample]) -> list[ComparedClutches]:
    """Return the first clutch against the next one, at each speed and measure of both."""
    clutches = list(dict.fromkeys(sample.clutch for sample in samples))
    at = {(sample.clutch, sample.speed_m_s, sample.measure): sample for sample in samples}
    pairs = []
    for new in samples:
        reference = at.get((clutches[1], new.speed_m_s, new.measure)) if clutches[1:] else None
        if new.clutch == clutches[0] and reference is not None:
            reduction = 100 * (1 - new.mean / reference.mean) if reference.mean else None
            chance = welch_probability(new, reference)
            pairs.append(ComparedClutches(new.speed_m_s, new.measure, reduction, chance))
    return pairs


def welch_probability(a: Sample, b: Sample) -> float | None:
    """Return the p-value of equal means with unequal variances (Welch 1947), None without any."""
    if a.sd == b.sd == 0:
        return None
    test = scipy.stats.ttest_ind_from_stats(a.mean, a.sd, a.n, b.mean, b.sd, b.n, equal_var=False)
    return float(test.pvalue)


def plan_field(
    array: str, factors: Sequence[str] = (), responses: Sequence[str] = (), seed: int | None = None
) -> FieldPlan:
    """Return a plan on an orthogonal array by name, in its order or shuffled by a seed.

    Factors are texts `NAME` or `NAME=LEVEL,...`. They take the array's basis first, then the
    columns that mix most of it, which two-factor interactions disturb least. Raises InputError for
    an unknown array, and for factors that do not fit it.
    """
    if array not in ARRAYS:
        raise InputError(f"{array}: there is no such plan, it must be one of {', '.join(ARRAYS)}")
    p, k = ARRAYS[array]
    runs = np.array(list(itertools.product(range(p), repeat=k)))
    # One column for each point of the projective space: its last entry beside zeros is one.
    points = itertools.product(range(p), repeat=k)
    vectors = [point for point in points if next(filter(None, point[::-1]), 0) == 1]
    vectors.sort(key=lambda v: (np.count_nonzero(v) != 1, -np.count_nonzero(v), v[::-1]))
    codes = runs @ np.array(vectors).T % p
    if seed is not None:
        codes = np.random.default_rng(seed).permutation(codes)
    columns = {"run": [str(run) for run in range(1, len(codes) + 1)]}
    for index, text in enumerate(factors or [chr(ord("A") + i) for i in range(codes.shape[1])]):
        name, equals, listed = (part.strip() for part in text.partition("="))
        levels = [level.strip() for level in listed.split(",")] if equals else range(1, p + 1)
        if index >= codes.shape[1] or len(levels) != p or not name or name in columns:
            raise InputError(
                f"--factor {text}: {array} has {codes.shape[1]} columns, for factors of different "
                f"names with {p} levels each, NAME or NAME=LEVEL,..."
            )
        columns[name] = [str(levels[code]) for code in codes[:, index]]
    for index in range(len(columns) - 1, codes.shape[1]):
        columns[f"blank{index}"] = [str(code + 1) for code in codes[:, index]]
    columns |= {name: [""] * len(codes) for name in responses or ["Y1"]}
    text = csv_rows.format_csv([f"Plan {array}."], columns, zip(*columns.values(), strict=True))
    return FieldPlan(array, columns, text)
