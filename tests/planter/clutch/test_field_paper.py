"""The field test of Shi et al. 2021: every printed number of its tables 2 to 4 that follows from
what it discloses.
"""

from __future__ import annotations

from functools import cache

import pytest

from planter.clutch.field import NEAREST_ZERO, evaluate_field
from planter.clutch.results import FieldTest

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


def compared(measure: str, speed: float) -> dict:
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
    assert result().order == {"Y1": ["A", "C", "B"], "Y2": ["B", "A", "C"]}
    assert result().range_best == {"Y1": [3, 1, 1], "Y2": [3, 1, 3]}
    k = {name: result().range[name]["C"].k for name in ("Y1", "Y2")}
    assert printed_as(k["Y1"][1] - k["Y1"][0], "1.1")
    assert printed_as(k["Y2"][2] - k["Y2"][1], "1.3")


def test_analysis_of_variance_is_as_printed() -> None:
    for response, sources in ANOVA.items():
        for source, texts in sources.items():
            row = result().anova[response][source]
            values = [getattr(row, key) for key in ("ss", "ms", "F", "p") if hasattr(row, key)]
            assert row.df == (8 if source == "total" else 2)
            assert all(printed_as(v, t) for v, t in zip(values, texts, strict=True)), (
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
    assert compared("Y1", 1.5).p_holm < 0.05
    assert compared("Y1", 2.0).p_holm < 0.05
    assert compared("Y2", 1.5).p_value > 0.5
    assert compared("Y2", 2.0).reduction_percent < 0
    seeding = [
        r
        for r in result().comparison + result().other_comparisons
        if r.measure == "qualified_percent"
    ]
    assert len(seeding) == 6
    assert min(r.p_value for r in seeding) > 0.3


def test_a_changed_run_is_noticed(tmp_path) -> None:  # type: ignore[no-untyped-def]
    from planter.files import examples

    path = tmp_path / "changed.csv"
    path.write_text(examples.example("shi2021-field").replace("5,2,2,3,1,7.7", "5,2,2,3,1,7.8"))
    evaluation = evaluate_field(
        str(path), requested=dict.fromkeys(("Y1", "Y2"), NEAREST_ZERO)
    ).result
    assert evaluation.comparison == []
    assert not printed_as(evaluation.anova["Y1"]["A"].F, "183.83")
