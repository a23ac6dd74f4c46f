"""Field tests: laws, the same numbers by other ways, plans, and what is refused."""

from __future__ import annotations

import csv
import io
import itertools
import json
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from planter.errors import InputError
from planter.papers.clutch import field
from planter.papers.clutch.field import Sample, Trial, evaluate_field, evaluate_trial, read_trial
from planter.papers.clutch.results import ComparedClutches, FieldTest
from tests.support.cli import answer, refusal, run

SIZES = {"L4": (4, 3, 2), "L8": (8, 7, 2), "L9": (9, 4, 3), "L25": (25, 6, 5), "L27": (27, 13, 3)}
PRINTED_L9 = "1111 1222 1333 2123 2231 2312 3132 3213 3321"  # shi2021, table 2
NEW, OLD = Sample("new", 1.5, "Y1", 1.2, 1.9, 5), Sample("old", 1.5, "Y1", 6.8, 2.5, 7)
SAMPLES = "clutch,speed_m_s,measure,mean,sd,n\nnew,1.5,Y1,1.2,1.9,5\nold,1.5,Y1,6.8,2.5,7\n"


def fill_plan(array: str, factors: int = 3, repeats: int = 1) -> Trial:
    """A plan with random responses."""
    random, plan = np.random.default_rng(20210206), field.plan_field(array)
    names = [name for name in plan.columns if name not in ("run", "Y1")]
    rows = list(zip(*(plan.columns[name] for name in names[:factors]), strict=True)) * repeats
    lines = [f"{','.join(row)},{random.normal(5, 3)},{random.gamma(2.0)}" for row in rows]
    return read_trial("\n".join([",".join([*names[:factors], "Y1", "Y2"]), *lines]), "test")


TRIALS = {"L9": ("L9", 3), "L8": ("L8", 4), "L27 twice": ("L27", 4, 2)}
GOALS = {"Y1": "larger", "Y2": "12.5"}


@pytest.fixture(params=TRIALS.values(), ids=TRIALS)
def trial(request: pytest.FixtureRequest) -> Trial:
    return fill_plan(*request.param)


def test_sums_of_squares_add_up_to_total(trial: Trial) -> None:
    for name, values in trial.responses.items():
        table = evaluate_trial(trial, GOALS).anova[name]
        parts = [row for source, row in table.items() if source != "total"]
        assert sum(row.ss for row in parts) == pytest.approx(table["total"].ss, rel=1e-12)
        assert sum(row.df for row in parts) == table["total"].df == len(values) - 1
        assert table["total"].ss == pytest.approx(len(values) * np.var(values), rel=1e-12)


@pytest.mark.parametrize("typ", [2])
def test_statsmodels_gives_the_same_table(trial: Trial, typ: int) -> None:
    pandas = pytest.importorskip("pandas")
    formula = pytest.importorskip("statsmodels.formula.api")
    anova_lm = pytest.importorskip("statsmodels.stats.anova").anova_lm
    result = evaluate_trial(trial, GOALS)
    codes = {f"F{name}": factor.codes for name, factor in trial.factors.items()}
    for name, values in trial.responses.items():
        terms = " + ".join(f"C({factor}, Sum)" for factor in codes)
        frame = pandas.DataFrame({**codes, "y": values})
        fit = formula.ols(f"y ~ {terms}", frame).fit()
        table = anova_lm(fit, typ=typ)
        for factor in codes:
            row, ours = table.loc[f"C({factor}, Sum)"], result.anova[name][factor[1:]]
            expected = (row["sum_sq"], row["df"], row["F"], row["PR(>F)"])
            assert (ours.ss, ours.df, ours.F, ours.p) == pytest.approx(expected, rel=1e-8)  # type: ignore[union-attr]
        rest = result.anova[name]["error"]
        assert (rest.ss, rest.df) == pytest.approx(tuple(table.loc["Residual", ["sum_sq", "df"]]))
        levels = [range(len(factor.levels)) for factor in trial.factors.values()]
        grid = np.array(list(itertools.product(*levels))).T
        predicted = fit.predict(pandas.DataFrame(dict(zip(codes, grid, strict=True))))
        assert [row.means[name] for row in result.prediction] == pytest.approx(list(predicted))


def test_without_error_there_is_no_test() -> None:
    table = evaluate_trial(fill_plan("L9", 4), GOALS).anova["Y1"]
    assert table["A"].F is table["A"].p is table["error"].ms is None  # type: ignore[union-attr]
    exact = fill_plan("L9", 3)
    level = {"Y1": exact.factors["A"].codes * 0.3 + exact.factors["B"].codes}
    table = evaluate_trial(replace(exact, responses=level), {"Y1": "larger"}).anova["Y1"]
    assert table["A"].F is None  # type: ignore[union-attr]


def test_goals_select_best_levels() -> None:
    trial = fill_plan("L9")
    for goal, loss in (
        ("larger", lambda y: -y),
        ("smaller", lambda y: y),
        ("4", lambda y: abs(y - 4)),
    ):
        result = evaluate_trial(trial, {"Y1": goal, "Y2": goal})
        best = min(result.prediction, key=lambda row: loss(row.means["Y1"]))
        assert result.best["Y1"] == best.levels
        by_rank = [
            np.argsort(np.argsort([loss(row.means[name]) for row in result.prediction]))
            for name in ("Y1", "Y2")
        ]
        first = result.prediction.index(
            next(r for r in result.prediction if r.levels == result.best["both"])
        )
        assert np.mean(by_rank, axis=0)[first] == np.mean(by_rank, axis=0).min()


def test_undefined_comparisons_are_null() -> None:
    still = replace(NEW, sd=0.0), replace(OLD, sd=0.0, mean=0.0)
    (comparison,) = field.compare_samples(still)
    assert comparison.p_value is comparison.reduction_percent is None
    assert field.compare_samples([NEW, replace(OLD, measure="Y2")]) == []


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [("1.9", "-1.9", "negative"), (",5\n", ",1\n", "from 2 on"), ("speed_m_s", "v", "speed_m_s")],
)
def test_bad_statistics_are_refused_by_place(old: str, new: str, message: str) -> None:
    with pytest.raises(InputError, match=rf"here\.csv.*{message}"):
        field.read_samples(SAMPLES.replace(old, new), "here.csv")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("A,B\n1,1\n2,2\n", "response"),
        ("Y1\n1\n2\n", "factor"),
        ("A,Y1\n1,3\n1,4\n", "column A: .* two levels"),
        ("A,Y1\n1,3\n2,3\n", "column Y1: .* vary"),
        ("A,Y1\n1,3\nlow,4\n", "A"),
        ("A,Y1\n1,3\n2,x\n", "Y1"),
        ("A,Y1\n1,3\n1,4\n2,5\n", "equally often"),
        ("A,B,Y1\n1,1,3\n2,2,4\n", "A and B .* equally often"),
    ],
)
def test_bad_files_are_refused(text: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        read_trial(text, "here.csv")


def test_header_assigns_columns() -> None:
    text = "# factor grade: grade of soil\nrun,grade,blank,error 2,Y,yield,y_2\n"
    text += "1,low,1,2,3,1,5\n2,high,2,1,4,2,6\n3,low,1,1,3,2,6\n4,high,2,2,4,1,9\n"
    trial = read_trial(text, "here.csv")
    assert list(trial.factors) == ["grade", "yield"]
    assert list(trial.responses) == ["Y", "y_2"]
    assert trial.factors["grade"].levels == ("low", "high")
    assert trial.labels == {"grade": "grade of soil"}


def test_goals_and_tables_of_a_user(tmp_path: Path) -> None:
    path = tmp_path / "own.csv"
    path.write_text("A,Y1\n1,3\n1,4\n2,5\n2,7\n", encoding="utf-8")
    samples = tmp_path / "samples.csv"
    samples.write_text(SAMPLES, encoding="utf-8")
    result = answer(
        "clutch", "field", str(path), "--goal", "Y1=larger", "--comparison", str(samples)
    )
    assert (result["best"]["both"], len(result["comparison"])) == ([2], 1)
    assert "--goal Y1=larger" in refusal("clutch", "field", str(path))
    for goal in ("Y2=larger", "Y1", "Y1=nan", "Y1=best"):
        assert "Y1" in refusal("clutch", "field", str(path), "--goal", goal)


def test_files_hold_the_result(tmp_path: Path) -> None:
    result = answer("clutch", "field", "--out", str(tmp_path))
    assert {"range", "anova", "goals", "best", "prediction", "comparison"} <= result.keys()
    summary = json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))
    assert result.items() <= summary.items()
    text = (tmp_path / "prediction.csv").read_text(encoding="utf-8").partition("\n")[2]
    for row, entry in zip(csv.DictReader(io.StringIO(text)), result["prediction"], strict=True):
        assert [int(row[name]) for name in "ABC"] == entry["levels"]
        assert float(row["Y1"]) == entry["Y1"]
    names = {path.name for path in tmp_path.rglob("*")}
    assert {"range.csv", "anova.csv", "comparison.csv", "effects.svg", "comparison.svg"} <= names


@pytest.mark.parametrize("name", SIZES)
def test_arrays_have_their_size_and_strength(name: str) -> None:
    plan = field.plan_field(name)
    rows, columns, levels = SIZES[name]
    listed = [plan.columns[key] for key in plan.columns if key not in ("run", "Y1")]
    assert (len(plan.columns["run"]), len(listed)) == (rows, columns)
    for a, b in itertools.combinations(listed, 2):
        pairs = list(zip(a, b, strict=True))
        assert {pairs.count(pair) for pair in pairs} == {rows // levels**2}
        assert len(set(pairs)) == levels**2


def test_the_paper_took_the_l9_as_it_stands() -> None:
    columns = field.plan_field("L9").columns
    rows = ["".join(row) for row in zip(*(columns[name] for name in "ABCD"), strict=True)]
    assert " ".join(rows) == PRINTED_L9


@pytest.mark.parametrize("name", ["L8", "L27"])
def test_first_factors_are_free_of_two_factor_interactions(name: str) -> None:
    """Any three of the first four columns hold all triples equally often (strength three)."""
    columns = field.plan_field(name).columns
    for three in itertools.combinations("ABCD", 3):
        triples = list(zip(*(columns[key] for key in three), strict=True))
        assert len({triples.count(triple) for triple in triples}) == 1
        assert len(set(triples)) == SIZES[name][2] ** 3


def test_plan_is_shuffled_written_and_read_back(tmp_path: Path) -> None:
    words = ("clutch", "plan", "L9", "--factor", "soil=dry,damp,wet", "--factor", "k")
    result = answer(*words, "--seed", "3", "--out", str(tmp_path))
    assert sorted(result["columns"]["soil"]) == ["damp"] * 3 + ["dry"] * 3 + ["wet"] * 3
    assert result["columns"]["soil"] != answer(*words)["columns"]["soil"]
    lines = (tmp_path / "plan.csv").read_text(encoding="utf-8").splitlines()
    filled = [line if i < 2 else f"{line}{i % 4}.5" for i, line in enumerate(lines)]
    trial = read_trial("\n".join(filled), "plan.csv")
    assert list(trial.factors) == ["soil", "k"]
    code, out, _ = run(*words)
    assert (code, out.splitlines()[1]) == (0, "run,soil,k,blank2,blank3,Y1")


@pytest.mark.parametrize(
    "words", [("L7",), ("L9", "--factor", "k=1,2"), ("L4", *["--factor", "k"] * 2)]
)
def test_impossible_plans_are_refused(words: tuple[str, ...]) -> None:
    assert words[0] in refusal("clutch", "plan", *words)


@cache
def result() -> FieldTest:
    """The paper's own field test; its tables of numbers are audited."""
    return evaluate_field().result


def compared(measure: str, speed: float) -> ComparedClutches:
    (comparison,) = [r for r in result().comparison if (r.measure, r.speed_m_s) == (measure, speed)]
    return comparison


def test_joint_optimum_is_as_printed() -> None:
    assert result().best == {"Y1": [3, 1, 1], "Y2": [1, 1, 3], "both": [3, 1, 1]}
    at = {tuple(row.levels): row.means for row in result().prediction}
    assert len(at) == 27
    assert abs(at[1, 1, 3]["Y2"]) < 0.3 < 5 < abs(at[3, 1, 3]["Y2"])


@pytest.mark.parametrize("measure", ["Y1", "Y2"])
def test_reductions_are_as_printed_at_the_optimum_speed(measure: str) -> None:
    assert (
        f"{compared(measure, 1.5).reduction_percent:.1f}" == {"Y1": "82.4", "Y2": "45.5"}[measure]
    )


def test_only_engagement_lag_is_significantly_reduced() -> None:
    assert compared("Y1", 1.5).p_value < 0.05
    assert compared("Y1", 2.0).p_value < 0.05
    assert compared("Y2", 1.5).p_value > 0.5
    assert compared("Y2", 2.0).reduction_percent < 0
    assert min(compared("qualified_percent", speed).p_value for speed in (1.5, 2.0)) > 0.3
