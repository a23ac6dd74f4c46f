"""The field test of Shi et al. 2021: every printed number of its tables 2 to 4 that follows from
what it discloses.
"""

from __future__ import annotations

from functools import cache

import pytest

from planter.papers.clutch.field import evaluate_field
from planter.papers.clutch.results import ComparedClutches, FieldTest

RANGE = {
    "Y1": {
        "A": ("9.8", "6.3", "3.3", "6.5"),
        "B": ("5.3", "6.5", "7.6", "2.3"),
        "C": ("5.2", "6.3", "7.9", "2.7"),
    },
    "Y2": {
        "A": ("-4.8", "-2.5", "0.1", "4.9"),
        "B": ("0.8", "-5.9", "-2.1", "6.8"),
        "C": ("-4.8", "-1.9", "-0.6", "4.2"),
    },
}
ANOVA = {
    "Y1": {
        "A": ("64.14", "32.07", "183.83", "0.0054"),
        "B": ("7.96", "3.98", "22.82", "0.0420"),
        "C": ("11.32", "5.66", "32.43", "0.0299"),
        "error": ("0.35", "0.17"),
        "total": ("83.76",),
    },
    "Y2": {
        "A": ("36.04", "18.02", "37.98", "0.0257"),
        "B": ("69.74", "34.87", "73.49", "0.0134"),
        "C": ("27.27", "13.63", "28.74", "0.0336"),
        "error": ("0.95", "0.47"),
        "total": ("134.00",),
    },
}
REDUCTION = {"Y1": "82.4", "Y2": "45.5"}


@cache
def result() -> FieldTest:
    return evaluate_field().result


def printed_as(value: float, text: str) -> bool:
    """Whether a number, rounded to as many places as are printed, is the printed one."""
    return f"{value:.{len(text.partition('.')[2])}f}" == text


def compared(measure: str, speed: float) -> ComparedClutches:
    (comparison,) = [r for r in result().comparison if (r.measure, r.speed_m_s) == (measure, speed)]
    return comparison


def test_range_analysis_is_as_printed_except_for_truncation() -> None:
    differing = []
    for response, factors in RANGE.items():
        for factor, texts in factors.items():
            range = result().range[response][factor]
            for place, (value, text) in enumerate(zip([*range.k, range.R], texts, strict=True), 1):
                if not printed_as(value, text):
                    differing.append((response, factor, place, round(value, 4)))
    assert differing == [("Y2", "B", 2, -5.9667)]


def test_order_and_best_levels_of_range_analysis_are_as_printed() -> None:
    means = result().range
    order = {name: sorted(means[name], key=lambda key: -means[name][key].R) for name in means}
    assert order == {"Y1": ["A", "C", "B"], "Y2": ["B", "A", "C"]}
    best = {
        name: [min((abs(k), i) for i, k in enumerate(m.k, 1))[1] for m in means[name].values()]
        for name in means
    }
    assert best == {"Y1": [3, 1, 1], "Y2": [3, 1, 3]}
    assert printed_as(means["Y1"]["C"].k[1] - means["Y1"]["C"].k[0], "1.1")
    assert printed_as(means["Y2"]["C"].k[2] - means["Y2"]["C"].k[1], "1.3")


def test_analysis_of_variance_is_as_printed() -> None:
    for response, sources in ANOVA.items():
        for source, texts in sources.items():
            row = result().anova[response][source]
            values = [getattr(row, key, None) for key in ("ss", "ms", "F", "p")]
            assert row.df == (8 if source == "total" else 2)
            assert all(printed_as(v, t) for v, t in zip(values, texts, strict=False)), (
                response,
                source,
                values,
            )


def test_printed_ratios_are_not_of_rounded_mean_squares() -> None:
    assert not printed_as(32.07 / 0.17, ANOVA["Y1"]["A"][2])


def test_joint_optimum_is_as_printed() -> None:
    assert result().best == {"Y1": [3, 1, 1], "Y2": [1, 1, 3], "both": [3, 1, 1]}
    at = {tuple(row.levels): row.means for row in result().prediction}
    assert len(at) == 27
    assert abs(at[1, 1, 3]["Y2"]) < 0.3 < 5 < abs(at[3, 1, 3]["Y2"])


@pytest.mark.parametrize("measure", REDUCTION)
def test_reductions_are_as_printed_at_the_optimum_speed(measure: str) -> None:
    assert printed_as(compared(measure, 1.5).reduction_percent, REDUCTION[measure])


def test_only_engagement_lag_is_significantly_reduced() -> None:
    assert compared("Y1", 1.5).p_value < 0.05
    assert compared("Y1", 2.0).p_value < 0.05
    assert compared("Y2", 1.5).p_value > 0.5
    assert compared("Y2", 2.0).reduction_percent < 0
    assert min(compared("qualified_percent", speed).p_value for speed in (1.5, 2.0)) > 0.3
