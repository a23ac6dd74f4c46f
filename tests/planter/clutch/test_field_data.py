"""Files of runs: columns, goals of responses, and refused files."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from planter.clutch.field import FieldColumns, ResponseGoal, evaluation, trial
from planter.clutch.results import FieldTest
from planter.errors import InputError
from planter.files import examples
from tests.support.cli import below

GOOD = examples.example("shi2021-field")
RUNS = "run,A,B,Y\n1,1,1,2\n2,1,2,5\n3,2,1,3\n4,2,2,6\n"


SUCCESS = """# response Y: seedlings planted upright / %
run,depth_mm,press,Y
1,30,low,71
2,30,high,80
3,40,low,86
4,40,high,97
5,30,low,73
6,40,high,95
"""
"""Success rates: the highest levels of both factors are best."""
run_field, answer_field, refuse_field = below("clutch", "field")


@pytest.fixture
def table(tmp_path: Path) -> str:
    path = tmp_path / "success.csv"
    path.write_text(SUCCESS)
    return str(path)


def evaluate(text: str, columns: FieldColumns | None = None, **goals: str) -> FieldTest:
    requested = {name: ResponseGoal.parse(goal) for name, goal in goals.items()}
    return evaluation.evaluate_trial(
        trial.read_trial(text, "x.csv", columns), requested=requested
    ).result


def refusal(text: str, columns: FieldColumns | None = None) -> str:
    """Return the message of a text that is refused when it is read and evaluated."""
    with pytest.raises(InputError) as refused:
        evaluate(text, columns)
    message = str(refused.value)
    assert "\n" not in message
    return message


def test_header_assigns_columns() -> None:
    read = trial.read_trial(GOOD, "x.csv")
    assert [f.name for f in read.factors] == ["A", "B", "C"]
    assert [r.name for r in read.responses] == ["Y1", "Y2"]
    assert [b.name for b in read.blanks] == ["blank"]
    assert read.factors[0].values == (10, 15, 20)
    assert read.factors[0].label == "axial angle / deg"
    assert read.responses[1].values[4] == -3.9


def test_options_say_otherwise() -> None:
    text = GOOD.replace("run,A,B,C,blank,Y1,Y2", "run,A,B,C,D,lag,note").replace(
        "response Y1", "response lag"
    )
    text = text.replace("# response Y2", "#")
    result = evaluate(text, FieldColumns(responses=("lag",), blanks=("D",), ignored=("note",)))
    assert (list(result.factors), result.blank) == (["A", "B", "C"], ["D"])
    assert result.anova["lag"] == evaluate(GOOD).anova["Y1"]


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_line_ends_spaces_and_empty_lines_do_not_matter(end: str) -> None:
    text = (
        GOOD.replace(",", " , ")
        .replace("\n", "\n\n")
        .replace(" , 15 , 20", ", 15, 20")
        .replace("\n", end)
    )
    assert evaluate(text) == evaluate(GOOD)


def test_levels_are_numbers_in_order_or_words_as_they_come() -> None:
    text = "A,B,Y\n10,soft,1\n9,hard,2.5\n10.0,hard,3\n9,soft,5\n"
    a, b = trial.read_trial(text, "x.csv").factors
    assert (a.levels, b.levels) == ((9, 10), ("soft", "hard"))
    assert a.codes.tolist() == [1, 0, 1, 0]
    assert (a.scale, b.scale) == ((9, 10), None)
    assert trial.read_trial("# factor B: = hard, soft\n" + text, "x.csv").factors[1].levels == (
        "hard",
        "soft",
    )


def test_results_name_the_levels_of_the_file() -> None:
    codes, levels = (
        GOOD.split("run,")[1].splitlines(),
        {"A": "10 15 20", "B": "0.3 0.4 0.5", "C": "1.5 2 2.5"},
    )
    rows = [line.split(",") for line in codes[1:]]
    evaluated = [
        [levels[n].split()[int(row[i]) - 1] for i, n in enumerate("ABC", 1)] + row[5:]
        for row in rows
    ]
    text = "\n".join(["A,B,C,Y1,Y2", *map(",".join, evaluated)])
    result = evaluate(text, Y1="zero", Y2="zero")
    assert result.best == {"Y1": [20, 0.3, 1.5], "Y2": [10, 0.3, 2.5], "both": [20, 0.3, 1.5]}
    assert result.anova == evaluate(GOOD).anova


def test_repetitions_of_a_run_add_to_the_error() -> None:
    twice = RUNS + "".join(
        f"{line.rpartition(',')[0]},{float(line.rpartition(',')[2]) + (-1) ** i}\n"
        for i, line in enumerate(RUNS.splitlines()[1:])
    )
    result = evaluate(twice)
    assert result.orthogonal
    assert result.anova["Y"]["error"].df == 5


def test_missing_runs_are_reported_or_unbalanced() -> None:
    lines = GOOD.splitlines()
    assert "run 8 is missing between 1 and 9" in refusal("\n".join([*lines[:-2], lines[-1]]))
    for text, columns in (
        ("\n".join(lines[:-1]), None),
        ("\n".join([*lines[:-2], lines[-1]]), FieldColumns(ignored=("run",))),
    ):
        result = evaluate(text, columns)
        assert result.range is None
        assert result.sums_of_squares == "type II"
        assert result.anova["Y1"]["error"].df == 1


BAD = {
    "nothing": ("", "the file is empty"),
    "comments alone": ("# nothing\n\n", "the file is empty"),
    "header alone": ("A,B,Y\n", "nothing below the header in line 1"),
    "duplicate header": ("A,A,Y\n1,2,3\n", "line 1: the header names A twice"),
    "nameless column": ("A,,Y\n1,2,3\n", "line 1: column 2 has no name"),
    "semicolons": ("A;B;Y\n1;2;3\n", "separated by commas"),
    "short row": (
        GOOD.replace("3,1,3,3,3,12.2,-2.6", "3,1,3,3,3,12.2"),
        "line 10 has 6 cells, but it must have 7",
    ),
    "long row": (GOOD.replace("12.2,-2.6", "12.2,-2.6,1"), "line 10 has 8 cells"),
    "empty response": (GOOD.replace("12.2,-2.6", ",-2.6"), "line 10, column Y1: it is empty"),
    "empty level": (
        GOOD.replace("3,1,3,3,3,12.2", "3,1,,3,3,12.2"),
        "line 10, column B: it is empty",
    ),
    "text": (GOOD.replace("12.2", "twelve"), "line 10, column Y1: 'twelve':"),
    "decimal comma": (GOOD.replace("12.2", '"12,2"'), "line 10, column Y1: '12,2':"),
    "nan": (GOOD.replace("12.2", "nan"), "line 10, column Y1: 'nan': it must be a finite number"),
    "inf": (GOOD.replace("12.2", "-inf"), "line 10, column Y1: '-inf':"),
    "overflow": (GOOD.replace("12.2", "1e999"), "column Y1: '1e999':"),
    "too large": (GOOD.replace("12.2", "1e200"), "at most 1e\\+100"),
    "underscore": (GOOD.replace("12.2", "1_2"), "column Y1: '1_2':"),
    "nan level": (GOOD.replace("3,1,3,3,3,12.2", "3,1,nan,3,3,12.2"), "line 10, column B: 'nan':"),
    "text level": (
        GOOD.replace("3,1,3,3,3,12.2", "3,1,x,3,3,12.2"),
        "line 10, column B: 'x' is not a number",
    ),
    "constant factor": ("A,B,Y\n1,2,3\n1,3,4\n1,2,5\n", "column A is 1 in every run"),
    "constant response": ("A,Y\n1,3\n2,3\n1,3\n", "column Y is 3 in every run"),
    "constant blank": ("A,blank,Y\n1,1,3\n2,1,4\n1,1,3\n", "column blank is 1 in every run"),
    "no response": (
        "A,B,C\n1,1,1\n2,2,2\n",
        "no column is a response .columns: A, B, C., it must be called Y",
    ),
    "no factor": ("run,Y1,Y2\n1,1,1\n2,2,2\n", "no column is a factor"),
    "fewer runs than effects": (
        "A,B,C,Y\n1,1,1,7.2\n1,2,2,10\n1,3,3,12.2\n2,1,2,4.8\n2,2,3,7.7\n3,2,1,1.9\n",
        r"6 runs for 7 effects \(the mean, 2 of A, 2 of B, 2 of C\)",
    ),
    "response not named": ("A,yield\n1,2\n2,2.5\n1,3\n2,3.7\n1,4\n", "no column is a response"),
    "run not whole": (RUNS.replace("2,1,2", "1.5,1,2"), "line 3, column run: 1.5:"),
    "run in words": (RUNS.replace("2,1,2", "two,1,2"), "line 3, column run: 'two':"),
    "run twice": (
        RUNS.replace("2,1,2", "1,1,2"),
        "line 3, column run: run 1 is in line 2 already with other levels",
    ),
    "factor of a reserved name": (
        RUNS.replace("A", "total"),
        "the column total is a factor, but results",
    ),
    "open quote": ('A,Y\n1,"2\n', "line 3 is not valid CSV"),
    "legend of no column": (
        "# factor Q: speed\n" + RUNS,
        "line 1 explains the factor Q, .* must be one of A, B",
    ),
    "legend of the wrong kind": (
        "# response A: speed\n" + RUNS,
        "line 1 explains the response A, .* one of Y",
    ),
    "legend too short": (
        GOOD.replace("10, 15, 20", "10, 15"),
        "line 2 gives A the values 10, 15, but its levels are 1, 2, 3",
    ),
    "level that no run has": (
        "".join(line + "\n" for line in GOOD.splitlines()[:13]),
        "line 2 gives A the values 10, 15, 20, but its levels are 1, 2: there must be one number "
        "for each",
    ),
    "legend in words": (
        GOOD.replace("10, 15, 20", "10, 15, more"),
        "line 2 gives A the values 10, 15, more",
    ),
    "legend of other words": (
        "# factor A: = x, z\nA,Y\nx,1\ny,2\nx,4\n",
        "the values x, z, but its levels are x, y",
    ),
}


@pytest.mark.parametrize(("text", "message"), BAD.values(), ids=BAD)
def test_bad_files_are_refused_by_place(text: str, message: str) -> None:
    refused_text = refusal(text)
    assert refused_text.startswith("x.csv:")
    assert re.search(message, refused_text), refused_text


def test_unknown_columns_in_options_are_refused() -> None:
    for columns, option in (
        (FieldColumns(("lag",)), "--response"),
        (FieldColumns((), ("D",)), "--blank"),
        (FieldColumns((), (), ("D",)), "--ignore"),
    ):
        assert f"{option} " in refusal(GOOD, columns)
    assert "must be one of run, A, B, C, blank, Y1, Y2" in refusal(GOOD, FieldColumns(("lag",)))
    assert "is a response, but results use" in refusal(
        RUNS.replace("Y", "both"), FieldColumns(("both",))
    )


def test_any_text_gives_a_result_or_an_input_error() -> None:
    random = np.random.default_rng(7)
    signs = list(GOOD) + list('",;#\n\t-eEnaN=:$_\x00é')
    messages: list[str] = []
    for _ in range(400):
        text = list(GOOD)
        for place in random.integers(0, len(text), random.integers(1, 6)):
            text[place] = signs[random.integers(len(signs))]
        try:
            evaluation = evaluate("".join(text))
        except InputError as error:
            messages.append(str(error))
        else:
            numbers = [
                row.means[name] for row in evaluation.prediction for name in evaluation.responses
            ]
            assert np.isfinite(numbers).all()
    assert 100 < len(messages) < 400
    assert not any("\n" in message for message in messages)


def test_goals_select_best_levels(table: str) -> None:
    result = answer_field(table, "--goal", "Y=larger")
    assert result["goals"] == {"Y": "larger"}
    assert result["best"] == {"Y": [40, "high"], "both": [40, "high"]}
    worst = answer_field(table, "--goal", "Y=zero")
    assert worst["goals"] == {"Y": "nearest 0"}
    assert (
        worst["best"]["Y"] == answer_field(table, "--goal", "Y=smaller")["best"]["Y"] == [30, "low"]
    )
    assert answer_field(table, "--goal", "Y=target 80")["goals"] == {"Y": "target 80"}
    nearest = answer_field(table, "--goal", "Y=86.4")
    assert (
        nearest["best"]["Y"]
        == min(nearest["prediction"], key=lambda row: abs(row["Y"] - 86.4))["levels"]
    )


def test_user_table_requires_goals(table: str) -> None:
    message = refuse_field(table)
    for part in ("nothing says what is good of Y", "--goal Y=larger", "smaller, zero, or a number"):
        assert part in message


@pytest.mark.parametrize(
    ("goal", "message"),
    [
        (["Y=large"], "must be larger, smaller, zero, or a number"),
        (["Y=nan"], "must be larger, smaller, zero, or a number"),
        (["Y"], "must be NAME=GOAL"),
        (["Q=larger", "Y=larger"], "has no such response, it must be one of Y"),
        (["Y=larger", "Y=smaller"], "Y has a goal already"),
    ],
)
def test_invalid_goals_are_refused(table: str, goal: list[str], message: str) -> None:
    assert message in refuse_field(
        table, *(part for stated_goal in goal for part in ("--goal", stated_goal))
    )


def test_paper_goals_can_be_replaced() -> None:
    assert answer_field()["goals"] == {"Y1": "nearest 0", "Y2": "nearest 0"}
    other = answer_field("--goal", "Y1=larger")
    assert other["goals"] == {"Y1": "larger", "Y2": "nearest 0"}
    assert other["best"]["Y1"] == [1, 3, 3]
    assert other["range_best"]["Y1"] == [1, 3, 3]


def test_joint_ranking_is_independent_of_units() -> None:
    def rank_best(unit: float) -> object:
        rows = (
            f"{a},{b},{unit * (10 * a + b)!r},{5 - a + 3 * b + 0.1 * a * b}\n"
            for a in (1, 2, 3)
            for b in (1, 2, 3)
        )
        return evaluate("A,B,Y1,Y2\n" + "".join(rows), Y1="larger", Y2="larger").best

    assert rank_best(1) == rank_best(1e6) == rank_best(1e-6)


def test_conflicting_goals_are_reported() -> None:
    text = "A,B,Y1,Y2\n" + "".join(
        f"{a},{b},{3 * a + b},{2 * (3 * a + b)}\n" for a in (1, 2, 3) for b in (1, 2, 3)
    )
    at_odds, agreed = (evaluate(text, Y1="larger", Y2=goal) for goal in ("smaller", "larger"))
    assert any(
        "9 combinations of levels share the best mean rank" in warning
        for warning in at_odds.warnings
    )
    assert not any("share the best" in warning for warning in agreed.warnings)
    assert agreed.best is not None
    assert agreed.best["both"] == [3, 3]


def test_losses_equal_up_to_rounding_share_a_rank() -> None:
    assert evaluation.rank_losses(np.array([2.0, 1.0, 1.0 + 1e-14, 5.0])).tolist() == [
        3,
        1.5,
        1.5,
        4,
    ]
    assert evaluation.order_combinations([np.array([3.0, 1, 2]), np.array([1.0, 3, 2])])[0] == 2
    with pytest.raises(InputError):
        evaluation.parse_goals(["Y=1e999"])


def test_terminal_page_and_summary_state_goals(table: str, tmp_path: Path) -> None:
    code, out, _ = run_field(table, "--goal", "Y=larger", "--out", str(tmp_path / "out"))
    assert code == 0
    assert "larger" in out
    page = (tmp_path / "out" / "report.html").read_text()
    assert "<th>goal</th>" in page.replace(' scope="col"', "")
    assert "goal of Y" in page
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["goals"] == {"Y": "larger"}
    assert "larger, smaller, zero" in " ".join(run_field("--help")[1].split())
