"""Main effects of field tests: laws first, then the same numbers by other ways."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy import stats

from planter.clutch.field import Factor, FieldResponse, Trial, trial
from planter.clutch.field import evaluation as field
from planter.clutch.field.analysis import MainEffectsModel, fit_least_squares, is_orthogonal
from planter.clutch.field.evaluation import ResponseGoal
from planter.clutch.field.plans import build_array
from planter.clutch.results import Effect, Predicted
from planter.errors import InputError


def runs_of(codes: np.ndarray, *responses: np.ndarray) -> Trial:
    """A trial with factors F0, F1, ... and responses Y1, Y2, ... whose levels count from 0."""
    factors = []
    for index, column in enumerate(codes.T):
        levels, inverse = np.unique(column, return_inverse=True)
        factors.append(Factor(f"F{index}", tuple(int(level) for level in levels), inverse))
    measured = (
        FieldResponse(f"Y{i}", np.asarray(values, dtype=float))
        for i, values in enumerate(responses, 1)
    )
    return Trial("test", tuple(factors), tuple(measured))


def rng() -> np.random.Generator:
    return np.random.default_rng(20210206)


def l9() -> Trial:
    return runs_of(build_array("L9").codes[:, :3], *rng().normal(5, 3, (2, 9)))


def l18() -> Trial:
    return runs_of(build_array("L18").codes[:, [0, 1, 2, 4, 6]], *rng().gamma(2.0, 1.0, (2, 18)))


def l27() -> Trial:
    return runs_of(
        np.vstack([build_array("L27").codes[:, [0, 1, 4, 8]]] * 2), rng().normal(-5, 3, 54)
    )


def unbalanced() -> Trial:
    """Factors of 2, 3 and 4 levels, in no order and not equally often."""
    random = rng()
    codes = np.column_stack([random.integers(0, size, 23) for size in (2, 3, 4)])
    return runs_of(codes, random.normal(100, 3, 23), codes[:, 0] + random.normal(0, 1, 23))


BALANCED = {"L9": l9, "L18": l18, "L27 twice": l27}
ANY = {**BALANCED, "unbalanced": unbalanced}
balanced = pytest.mark.parametrize("make", BALANCED.values(), ids=BALANCED)
any_design = pytest.mark.parametrize("make", ANY.values(), ids=ANY)


def changed(experiment: Trial, values: object, rows: object = slice(None)) -> Trial:
    """The trial with other responses, runs reordered by `rows`."""
    factors = tuple(Factor(f.name, f.levels, f.codes[rows]) for f in experiment.factors)
    responses = tuple(FieldResponse(r.name, values(r.values)[rows]) for r in experiment.responses)  # type: ignore[operator]
    return Trial(experiment.source, factors, responses)


def frame(experiment: Trial, response: FieldResponse):  # type: ignore[no-untyped-def]
    pandas = pytest.importorskip("pandas")
    return pandas.DataFrame({f.name: f.codes for f in experiment.factors} | {"y": response.values})


def by_formula(experiment: Trial, response: FieldResponse, typ: int):  # type: ignore[no-untyped-def]
    """Analysis of variance as statsmodels writes it: {factor: (ss, df, F, p)}, residual (ss,
    df).
    """
    fit = (
        pytest.importorskip("statsmodels.formula.api")
        .ols(
            "y ~ " + " + ".join(f"C({f.name}, Sum)" for f in experiment.factors),
            frame(experiment, response),
        )
        .fit()
    )
    table = pytest.importorskip("statsmodels.stats.anova").anova_lm(fit, typ=typ)
    rows = {f.name: table.loc[f"C({f.name}, Sum)"] for f in experiment.factors}
    by_name = {name: (row["sum_sq"], row.df, row.F, row["PR(>F)"]) for name, row in rows.items()}
    return by_name, (table.loc["Residual", "sum_sq"], table.loc["Residual", "df"]), fit


def assert_same(experiment: Trial, typ: int) -> None:
    model = MainEffectsModel(experiment)
    for response in experiment.responses:
        table_rows = model.anova(response)
        other, residual, _ = by_formula(experiment, response, typ)
        for name, row in other.items():
            assert [
                getattr(table_rows[name], key) for key in ("ss", "df", "F", "p")
            ] == pytest.approx(row, rel=1e-8, abs=1e-13)
        assert (table_rows["error"].ss, table_rows["error"].df) == pytest.approx(residual, rel=1e-9)


@balanced
def test_orthogonal_sums_of_squares_add_up_to_total(make) -> None:  # type: ignore[no-untyped-def]
    experiment = make()
    assert is_orthogonal(experiment.factors)
    for response in experiment.responses:
        table = MainEffectsModel(experiment).anova(response)
        parts = [row for name, row in table.items() if name != "total"]
        assert sum(row.ss for row in parts) == pytest.approx(table["total"].ss, rel=1e-12)
        assert sum(row.df for row in parts) == table["total"].df == experiment.runs - 1
        assert table["total"].ss == pytest.approx(
            experiment.runs * np.var(response.values), rel=1e-12
        )


def test_unbalanced_sums_of_squares_do_not_add_up() -> None:
    experiment = unbalanced()
    assert not is_orthogonal(experiment.factors)
    table = MainEffectsModel(experiment).anova(experiment.responses[1])
    assert abs(sum(r.ss for n, r in table.items() if n != "total") / table["total"].ss - 1) > 1e-4


@any_design
def test_the_order_of_the_runs_does_not_matter(make) -> None:  # type: ignore[no-untyped-def]
    experiment = make()
    other = changed(experiment, lambda y: y, rng().permutation(experiment.runs))
    for first, second in zip(experiment.responses, other.responses, strict=True):
        table_rows, theirs = (
            MainEffectsModel(experiment).anova(first),
            MainEffectsModel(other).anova(second),
        )
        for name, row in table_rows.items():
            assert theirs[name].table() == pytest.approx(row.table(), rel=1e-9, abs=1e-13)
        assert MainEffectsModel(other).effects(second).predict() == pytest.approx(
            MainEffectsModel(experiment).effects(first).predict(), rel=1e-11
        )


@any_design
@pytest.mark.parametrize(("shift", "scale"), [(1e4, 1.0), (0.0, -3.0), (-7.0, 1e-80), (0.0, 1e80)])
def test_shift_and_scale_of_the_response(make, shift: float, scale: float) -> None:  # type: ignore[no-untyped-def]
    experiment = make()
    other = changed(experiment, lambda y: scale * y + shift * abs(scale))
    model = MainEffectsModel(experiment)
    for first, second in zip(experiment.responses, other.responses, strict=True):
        table_rows, theirs = model.anova(first), model.anova(second)
        for name in (f.name for f in experiment.factors):
            assert theirs[name].ss == pytest.approx(scale**2 * table_rows[name].ss, rel=1e-7, abs=0)
            assert (theirs[name].F, theirs[name].p) == pytest.approx(
                (table_rows[name].F, table_rows[name].p), rel=1e-7
            )
        expected = scale * model.effects(first).predict() + shift * abs(scale)
        assert model.effects(second).predict() == pytest.approx(expected, rel=1e-9, abs=0)


@balanced
def test_range_analysis_gives_the_sums_of_squares(make) -> None:  # type: ignore[no-untyped-def]
    experiment = make()
    result = field.evaluate_trial(experiment).result
    for response, factor in itertools.product(experiment.responses, experiment.factors):
        analysed = result.range[response.name][factor.name]
        k = np.array(analysed.k)
        repeated = experiment.runs / len(factor.levels)
        ss = result.anova[response.name][factor.name].ss
        assert repeated * np.sum((k - response.values.mean()) ** 2) == pytest.approx(ss, rel=1e-10)
        assert pytest.approx(k.max() - k.min(), rel=1e-15) == analysed.R


@any_design
def test_projections_give_the_same(make) -> None:  # type: ignore[no-untyped-def]
    """Sums of squares from projections on indicator columns, without any coding or regression."""
    experiment = make()

    def projected(factors, y):  # type: ignore[no-untyped-def]
        columns = [
            np.ones((experiment.runs, 1)),
            *(np.eye(len(f.levels))[f.codes] for f in factors),
        ]
        x = np.hstack(columns)
        return x @ np.linalg.pinv(x) @ y

    for response in experiment.responses:
        table = MainEffectsModel(experiment).anova(response)
        full = projected(experiment.factors, response.values)
        for factor in experiment.factors:
            rest = projected([f for f in experiment.factors if f is not factor], response.values)
            assert table[factor.name].ss == pytest.approx(np.sum((full - rest) ** 2), rel=1e-8)
        assert table["error"].ss == pytest.approx(np.sum((response.values - full) ** 2), rel=1e-8)


@any_design
def test_statsmodels_formula_interface_gives_the_same(make) -> None:  # type: ignore[no-untyped-def]
    experiment = make()
    for typ in (1, 2, 3) if is_orthogonal(experiment.factors) else (2, 3):
        assert_same(experiment, typ)


def test_comparison_with_type_i_squares_fails() -> None:
    experiment = unbalanced()
    with pytest.raises(AssertionError):
        assert_same(experiment, 1)


@any_design
def test_predictions_are_those_of_the_formula_interface(make) -> None:  # type: ignore[no-untyped-def]
    pandas = pytest.importorskip("pandas")
    experiment = make()
    result = field.evaluate_trial(experiment).result
    combinations = list(itertools.product(*(range(len(f.levels)) for f in experiment.factors)))
    assert len(result.prediction) == len(combinations)
    for response in experiment.responses:
        *_, fit = by_formula(experiment, response, 2)
        rows = {f.name: [c[i] for c in combinations] for i, f in enumerate(experiment.factors)}
        table_rows = [row.means[response.name] for row in result.prediction]
        assert table_rows == pytest.approx(
            fit.predict(pandas.DataFrame(rows)).to_numpy(), rel=1e-9, abs=1e-11
        )


LONGLEY = """\
60323 83.0 234289 2356 1590 107608 1947
61122 88.5 259426 2325 1456 108632 1948
60171 88.2 258054 3682 1616 109773 1949
61187 89.5 284599 3351 1650 110929 1950
63221 96.2 328975 2099 3099 112075 1951
63639 98.1 346999 1932 3594 113270 1952
64989 99.0 365385 1870 3547 115094 1953
63761 100.0 363112 3578 3350 116219 1954
66019 101.2 397469 2904 3048 117388 1955
67857 104.6 419180 2822 2857 118734 1956
68169 108.4 442769 2936 2798 120445 1957
66513 110.8 444546 4681 2637 121950 1958
68655 112.6 482704 3813 2552 123366 1959
69564 114.2 502601 3931 2514 125368 1960
69331 115.7 518173 4806 2572 127852 1961
70551 116.9 554894 4007 2827 130081 1962
"""


def test_least_squares_reproduce_certified_values_of_nist() -> None:
    """Longley's data, of a condition number of 5e9, from the Statistical Reference Datasets of
    NIST.
    """
    table = np.array([row.split() for row in LONGLEY.splitlines()], dtype=float)
    fit = fit_least_squares(table[:, 0], np.column_stack([np.ones(16), table[:, 1:]]))
    certified = (
        -3482258.63459582,
        15.0618722713733,
        -0.358191792925910e-01,
        -2.02022980381683,
        -1.03322686717359,
        -0.511041056535807e-01,
        1829.15146461355,
    )
    assert fit.parameters == pytest.approx(certified, rel=1e-7)
    assert fit.residual_squares == pytest.approx(836424.055505915, rel=1e-9)
    table[0, 1] += 0.1
    tampered = fit_least_squares(table[:, 0], np.column_stack([np.ones(16), table[:, 1:]]))
    assert tampered.residual_squares != pytest.approx(836424.055505915, rel=1e-4)


def test_variances_of_a_textbook_example() -> None:
    """Etch rates at four powers: Montgomery, Design and Analysis of Experiments, chapter 3."""
    y = np.array(
        [
            575,
            542,
            530,
            539,
            570,
            565,
            593,
            590,
            579,
            610,
            600,
            651,
            610,
            637,
            629,
            725,
            700,
            715,
            685,
            710.0,
        ]
    )
    table = MainEffectsModel(runs_of(np.repeat(np.arange(4), 5)[:, None], y)).anova(
        FieldResponse("Y", y)
    )
    assert [table[key].ss for key in ("F0", "error", "total")] == pytest.approx(
        [66870.55, 5339.20, 72209.75]
    )
    assert [table[key].df for key in ("F0", "error", "total")] == [3, 16, 19]
    assert pytest.approx(66.80, abs=0.005) == table["F0"].F


def test_single_factor_agrees_with_scipy_anova() -> None:
    codes = np.repeat([0, 1, 2], [4, 6, 9])
    y = rng().normal(codes, 1.0)
    row = MainEffectsModel(runs_of(codes[:, None], y)).anova(FieldResponse("Y", y))["F0"]
    other = stats.f_oneway(*(y[codes == code] for code in range(3)))
    assert (row.F, row.p) == pytest.approx((other.statistic, other.pvalue), rel=1e-10)


def test_best_levels_agree_with_exhaustive_search() -> None:
    experiment = l18()
    result = field.evaluate_trial(
        experiment, requested={"Y1": ResponseGoal.parse("zero"), "Y2": ResponseGoal.parse("larger")}
    ).result
    scores = {"Y1": lambda row: abs(row.means["Y1"]), "Y2": lambda row: -row.means["Y2"]}
    for name, score in scores.items():
        assert result.best[name] == min(result.prediction, key=score).levels

    def mean_rank(row: Predicted) -> int:
        return sum(
            sum(score(other) < score(row) for other in result.prediction)
            for score in scores.values()
        )

    assert result.best["both"] == min(result.prediction, key=mean_rank).levels


def test_ties_select_the_first_level_in_any_run_order() -> None:
    codes = build_array("L9").codes[:, :2]
    y = np.array([3.0, 1.0, 1.0])[codes[:, 0]] + 0.1
    random = rng()
    for _ in range(20):
        experiment = changed(runs_of(codes, y), lambda v: v, random.permutation(9))
        assert field.evaluate_trial(
            experiment, requested={"Y1": ResponseGoal.parse("0")}
        ).result.best["Y1"] == [1, 0]


def test_unbalanced_design_has_type_ii_squares_and_no_ranges() -> None:
    result = field.evaluate_trial(unbalanced()).result
    assert result.range is result.order is result.range_best is None
    assert result.sums_of_squares == "type II"
    assert "not orthogonal" in result.warnings[0]
    assert all(row.p is not None for row in result.anova["Y1"].values() if isinstance(row, Effect))


def test_balanced_levels_are_not_always_orthogonal() -> None:
    codes = build_array("L9").codes[:, :2].copy()
    assert is_orthogonal(runs_of(codes, np.arange(9.0)).factors)
    codes[[0, 4], 1] = codes[[4, 0], 1]
    experiment = runs_of(codes, np.arange(9.0))
    assert all(np.ptp(np.bincount(f.codes)) == 0 for f in experiment.factors)
    assert not is_orthogonal(experiment.factors)


def test_without_freedom_for_the_error_there_is_no_test() -> None:
    result = field.evaluate_trial(runs_of(build_array("L9").codes, rng().normal(0, 1, 9))).result
    assert result.anova["Y1"]["error"].df == 0
    assert result.anova["Y1"]["error"].ms is None
    assert all(result.anova["Y1"][f"F{i}"].F is None for i in range(4))
    assert result.anova["Y1"]["F0"].ss > 0
    assert "degrees of freedom" in result.warnings[0]


def test_responses_without_any_error_have_no_test() -> None:
    codes = build_array("L9").codes[:, :3]
    result = field.evaluate_trial(runs_of(codes, 0.1 * codes @ [1.0, 0.3, 0.7] + 12.3)).result
    assert result.anova["Y1"]["F0"].p is None
    assert "to the last digit" in result.warnings[0]
    nearly = 0.1 * codes @ [1.0, 0.3, 0.7] + 12.3 + 1e-9 * rng().normal(0, 1, 9)
    assert field.evaluate_trial(runs_of(codes, nearly)).result.anova["Y1"]["F0"].p > 0


def test_fewer_runs_than_effects_are_counted() -> None:
    codes = build_array("L9").codes[:6]
    with pytest.raises(
        InputError, match=r"6 runs for 8 effects \(the mean, 1 of F0, 2 of F1, 2 of F2, 2 of F3\)"
    ):
        MainEffectsModel(runs_of(codes, np.arange(6.0)))
    assert MainEffectsModel(runs_of(build_array("L9").codes, np.arange(9.0))).freedom == 0


def test_confounded_effects_are_named() -> None:
    codes = build_array("L27").codes[:, [0, 1, 4, 0]]
    with pytest.raises(InputError, match="effects of F0 and F3 cannot be separated"):
        MainEffectsModel(runs_of(codes, np.arange(27.0)))


def test_more_than_can_be_analysed_is_refused() -> None:
    codes = np.column_stack([np.arange(4000) % 2000, np.arange(4000) % 2])
    with pytest.raises(InputError, match="4000 runs times 2001 effects are too many"):
        MainEffectsModel(runs_of(codes, np.arange(4000.0)))


@pytest.mark.parametrize(("listed", "searched"), [(18, 18), (17, 18), (17, 17)])
def test_long_lists_of_predictions_are_left_out_loudly(
    monkeypatch: pytest.MonkeyPatch, listed: int, searched: int
) -> None:
    monkeypatch.setattr(field, "LISTED", listed)
    monkeypatch.setattr(field, "SEARCHED", searched)
    experiment = runs_of(build_array("L18").codes[:, :3], rng().normal(0, 1, 18))
    result = field.evaluate_trial(
        experiment, requested={"Y1": ResponseGoal.parse("smaller")}
    ).result
    assert len(result.prediction) == (18 if listed >= 18 else 0)
    assert (result.best is None) == (searched < 18)
    assert any("of 18 combinations" in warning for warning in result.warnings) == (listed < 18)


@pytest.mark.parametrize("good", [True, False])
def test_blank_column_with_effects_is_reported(good: bool) -> None:
    pairs = list(itertools.product((0, 1, 2), repeat=2))
    rows = [f"{a},{b},{(a + b) % 3 if good else a},{a + 2 * b + 0.1 * a * b}" for a, b in pairs]
    result = field.evaluate_trial(
        trial.read_trial("\n".join(["A,B,blank,Y", *rows]), "x.csv")
    ).result
    assert any("blank column blank" in warning for warning in result.warnings) != good
