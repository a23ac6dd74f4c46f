"""Clutches compared from summary statistics."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from planter.clutch.field import analysis
from planter.clutch.field.analysis import Sample
from planter.errors import InputError

HEAD = "clutch,speed_m_s,measure,mean,sd,n\n"
NEW, OLD = Sample("new", 1.5, "Y1", 1.2, 1.9, 5), Sample("old", 1.5, "Y1", 6.8, 2.5, 7)


def sample_of(values: np.ndarray, clutch: str) -> Sample:
    return Sample(clutch, 2.0, "Y1", float(values.mean()), float(values.std(ddof=1)), len(values))


def test_raw_measurements_give_the_same_p() -> None:
    random = np.random.default_rng(1)
    for sizes in itertools.product((2, 5, 30), repeat=2):
        a, b = random.normal(0, 1, sizes[0]), random.normal(1, 3, sizes[1])
        raw = stats.ttest_ind(a, b, equal_var=False).pvalue
        assert analysis.welch_probability(sample_of(a, "a"), sample_of(b, "b")) == pytest.approx(
            raw, rel=1e-9
        )
        if sizes[0] != sizes[1]:
            pooled = stats.ttest_ind(a, b, equal_var=True).pvalue
            assert analysis.welch_probability(
                sample_of(a, "a"), sample_of(b, "b")
            ) != pytest.approx(pooled, rel=1e-3)


def test_welch_by_hand() -> None:
    va, vb = 1.9**2 / 5, 2.5**2 / 7
    freedom = (va + vb) ** 2 / (va**2 / 4 + vb**2 / 6)
    p = 2 * stats.t.sf(abs(1.2 - 6.8) / np.sqrt(va + vb), freedom)
    assert analysis.welch_probability(NEW, OLD) == pytest.approx(p, rel=1e-12)


def test_unit_and_order_of_clutches_do_not_matter_to_p() -> None:
    scaled = [replace(s, mean=s.mean * 1e-90, sd=s.sd * 1e-90) for s in (NEW, OLD)]
    p = analysis.welch_probability(NEW, OLD)
    assert analysis.welch_probability(OLD, NEW) == pytest.approx(p, rel=1e-12)
    assert analysis.welch_probability(*scaled) == pytest.approx(p, rel=1e-9)
    assert analysis.welch_probability(replace(NEW, mean=OLD.mean), OLD) == pytest.approx(
        1, abs=1e-12
    )


def test_holm_by_hand_and_pairs_in_their_order() -> None:
    samples = [Sample(c, 1.0, "Y1", m, 1.0, 6) for c, m in (("a", 0.0), ("b", 1.0), ("c", 3.0))]
    main, comparisons = analysis.compare_samples(samples)
    pairs = [*main, *comparisons]
    assert [(p.clutch, p.reference) for p in pairs] == [("a", "b"), ("a", "c"), ("b", "c")]
    assert len(main) == 1
    rising = sorted(pairs, key=lambda p: p.p_value)
    steps = np.maximum.accumulate([(3 - i) * p.p_value for i, p in enumerate(rising)])
    assert [p.p_holm for p in rising] == pytest.approx(np.minimum(steps, 1))


@pytest.mark.parametrize("count", [1, 2, 9])
def test_holm_agrees_with_statsmodels(count: int) -> None:
    probabilities = np.random.default_rng(count).beta(0.5, 3.0, count)
    reference = pytest.importorskip("statsmodels.stats.multitest").multipletests
    assert analysis.adjust_by_holm([*probabilities]) == pytest.approx(
        reference(probabilities, method="holm")[1]
    )
    if count > 1:
        other = reference(probabilities, method="bonferroni")[1]
        assert analysis.adjust_by_holm([*probabilities]) != pytest.approx(other)


def test_holm_is_at_most_unity_and_preserves_ties() -> None:
    assert analysis.adjust_by_holm([0.5, 0.02, 0.5, 0.02]) == [1.0, 0.08, 1.0, 0.08]
    assert analysis.adjust_by_holm([]) == []


def test_undefined_comparisons_are_null() -> None:
    still = [replace(s, sd=0.0) for s in (NEW, OLD)]
    (comparison,), _ = analysis.compare_samples([still[0], replace(still[1], mean=0.0)])
    assert comparison.p_value is comparison.p_holm is comparison.reduction_percent is None
    (comparison,), _ = analysis.compare_samples([still[0], OLD])
    assert 0 < comparison.p_value < 1
    (comparison,), _ = analysis.compare_samples(
        [replace(NEW, mean=1e100), replace(OLD, mean=1e-300)]
    )
    assert comparison.reduction_percent is None
    assert analysis.compare_samples([NEW, replace(OLD, measure="Y2")]) == ([], [])


BAD = {
    "other columns": (
        "clutch,speed,measure,mean,sd,n\na,1,Y1,1,1,5\n",
        "the header .clutch,speed,measure",
    ),
    "negative": (HEAD + "a,1,Y1,1,-1,5\nb,1,Y1,1,1,5\n", "line 2, column sd: -1:"),
    "one measurement": (HEAD + "a,1,Y1,1,1,5\nb,1,Y1,1,1,1\n", "line 3, column n: 1:"),
    "half a measurement": (HEAD + "a,1,Y1,1,1,2.5\n", "column n: 2.5:"),
    "text": (HEAD + "a,1,Y1,much,1,5\n", "line 2, column mean: 'much':"),
    "twice": (
        HEAD + "a,1,Y1,1,1,5\nb,1,Y1,1,1,5\na,1.0,Y1,2,1,5\n",
        "line 4 gives Y1 of a at 1 m/s again after line 2",
    ),
    "one clutch": (HEAD + "a,1,Y1,1,1,5\n", "column clutch names 1, there must be 2 to 20"),
    "no name": (HEAD + ",1,Y1,1,1,5\n", "line 2, column clutch: it is empty"),
}


@pytest.mark.parametrize(("text", "message"), BAD.values(), ids=BAD)
def test_bad_statistics_are_refused_by_place(text: str, message: str) -> None:
    with pytest.raises(InputError, match=message) as refused:
        analysis.read_samples(text, "stats.csv")
    assert str(refused.value).startswith("stats.csv:")
    assert len(analysis.read_samples(HEAD + "a,1,Y1,1,1,5\nb,1,Y1,1,1,5\n", "stats.csv")) == 2
