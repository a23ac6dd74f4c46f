"""Comparison of clutches from means, standard deviations and numbers of measurements."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from planter.clutch.results.field import Compared
from planter.errors import InputError
from planter.files import csv_rows

MOST_CLUTCHES = 20
HEADER = ("clutch", "speed_m_s", "measure", "mean", "sd", "n")


@dataclass(frozen=True)
class Sample:
    """Summary of the measurements of one clutch at one speed; `sd` is the sample standard deviation."""

    clutch: str
    speed_m_s: float
    measure: str
    mean: float
    sd: float
    n: int


def read_samples(text: str, source: str) -> list[Sample]:
    """Return the samples of a CSV text with the columns of `HEADER`. Raises InputError, naming line and column."""
    table = csv_rows.read(text, source, HEADER)
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


def _check(table: csv_rows.Table) -> None:
    for row, sd in enumerate(table.numbers("sd")):
        if sd < 0:
            raise InputError(f"{table.place(row, 'sd')}: {sd:g} is not allowed, it must not be negative")
    for row, n in enumerate(table.numbers("n")):
        if n < 2 or not n.is_integer():
            raise InputError(f"{table.place(row, 'n')}: {n:g} is not allowed, it must be a whole number from 2 on")


def _check_distinct(table: csv_rows.Table, samples: Sequence[Sample]) -> None:
    seen: dict[tuple[str, float, str], int] = {}
    for sample, line in zip(samples, table.lines, strict=True):
        before = seen.setdefault((sample.clutch, sample.speed_m_s, sample.measure), line)
        if before != line:
            raise InputError(
                f"{table.source}: line {line} gives {sample.measure} of {sample.clutch} at {sample.speed_m_s:g} m/s "
                f"again after line {before}, but each must be given once"
            )
    clutches = len({sample.clutch for sample in samples})
    if not 2 <= clutches <= MOST_CLUTCHES:
        raise InputError(f"{table.source}: column clutch names {clutches}, there must be 2 to {MOST_CLUTCHES}")


def compare_samples(samples: Sequence[Sample]) -> tuple[list[Compared], list[Compared]]:
    """Return every pair of clutches at each speed and measure of both: the first two clutches, then all others.

    `reduction_percent` is (reference - clutch) / reference of the means, None for a reference of zero; `p_value` is
    that of Welch's two-sided test, None where neither clutch scatters; `p_holm` is the same by Holm's procedure over
    all pairs: what is called significant by it holds for all of them together.
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
    """Return the p-value of equal means with unequal variances (Welch 1947), or None if neither clutch scatters."""
    from scipy import stats

    scale = max(a.sd, b.sd)
    if scale == 0:
        return None
    gap = (a.mean - b.mean) / scale
    test = stats.ttest_ind_from_stats(gap, a.sd / scale, a.n, 0.0, b.sd / scale, b.n, equal_var=False)
    return float(test.pvalue)


def _adjusted(pairs: Sequence[Compared]) -> list[Compared]:
    """The pairs with their chances by Holm's procedure."""
    adjusted = iter(adjust_by_holm([pair.p_value for pair in pairs if pair.p_value is not None]))
    return [pair if pair.p_value is None else replace(pair, p_holm=next(adjusted)) for pair in pairs]


def adjust_by_holm(probabilities: Sequence[float]) -> list[float]:
    """Return probabilities adjusted for their number by the step-down procedure of Holm (1979), in the same order.

    The k-th smallest of m is multiplied by m - k + 1, is at least the adjusted one before it, and at most 1.

    >>> adjust_by_holm([0.01, 0.04, 0.03])
    [0.03, 0.06, 0.06]
    """
    adjusted, largest = [0.0] * len(probabilities), 0.0
    for rank, index in enumerate(sorted(range(len(probabilities)), key=probabilities.__getitem__)):
        largest = max(largest, min(1.0, (len(probabilities) - rank) * probabilities[index]))
        adjusted[index] = largest
    return adjusted
