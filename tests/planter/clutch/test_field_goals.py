"""What is good of a response: only its user knows, and results, page and figures say it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from planter.clutch.field import ResponseGoal, evaluation, trial
from planter.errors import InputError
from tests.support.cli import below

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

run, answer, refusal = below("clutch", "field")


@pytest.fixture
def table(tmp_path: Path) -> str:
    path = tmp_path / "success.csv"
    path.write_text(SUCCESS)
    return str(path)


def test_a_success_rate_is_to_be_large_and_not_near_zero(table: str) -> None:
    found = answer(table, "--goal", "Y=larger")
    assert found["goals"] == {"Y": "larger"}
    assert found["best"] == {"Y": [40, "high"], "both": [40, "high"]}
    worst = answer(table, "--goal", "Y=zero")
    assert worst["goals"] == {"Y": "nearest 0"}
    assert worst["best"]["Y"] == answer(table, "--goal", "Y=smaller")["best"]["Y"] == [30, "low"]
    assert answer(table, "--goal", "Y=target 80")["goals"] == {"Y": "target 80"}
    near = answer(table, "--goal", "Y=86.4")
    assert near["best"]["Y"] == min(near["prediction"], key=lambda row: abs(row["Y"] - 86.4))["levels"]


def test_user_table_requires_goals(table: str) -> None:
    message = refusal(table)
    assert "nothing says what is good of Y" in message
    assert "--goal Y=larger" in message
    assert "smaller, zero, or a number" in message


@pytest.mark.parametrize(
    ("goal", "said"),
    [
        (["Y=large"], "must be larger, smaller, zero, or a number"),
        (["Y=nan"], "must be larger, smaller, zero, or a number"),
        (["Y"], "must be NAME=GOAL"),
        (["Q=larger", "Y=larger"], "has no such response, it must be one of Y"),
        (["Y=larger", "Y=smaller"], "Y has a goal already"),
    ],
)
def test_invalid_goals_are_refused(table: str, goal: list[str], said: str) -> None:
    assert said in refusal(table, *(part for one in goal for part in ("--goal", one)))


def test_paper_goals_can_be_replaced() -> None:
    assert answer()["goals"] == {"Y1": "nearest 0", "Y2": "nearest 0"}
    other = answer("--goal", "Y1=larger")
    assert other["goals"] == {"Y1": "larger", "Y2": "nearest 0"}
    assert other["best"]["Y1"] == [1, 3, 3]
    assert other["range_best"]["Y1"] == [1, 3, 3]


def test_all_together_are_judged_by_ranks_whatever_their_units() -> None:
    text = "A,B,Y1,Y2\n" + "".join(
        f"{a},{b},{10 * a + b},{5 - a + 3 * b + 0.1 * a * b}\n" for a in (1, 2, 3) for b in (1, 2, 3)
    )
    wanted = {"Y1": ResponseGoal.parse("larger"), "Y2": ResponseGoal.parse("larger")}
    found = evaluation.evaluate_trial(trial.read_trial(text, "x.csv"), requested=wanted).result
    for unit in (1e6, 1e-6):
        scaled = "A,B,Y1,Y2\n" + "".join(
            f"{a},{b},{unit * (10 * a + b)!r},{5 - a + 3 * b + 0.1 * a * b}\n" for a in (1, 2, 3) for b in (1, 2, 3)
        )
        assert evaluation.evaluate_trial(trial.read_trial(scaled, "x.csv"), requested=wanted).result.best == found.best


def test_conflicting_goals_are_reported() -> None:
    text = "A,B,Y1,Y2\n" + "".join(f"{a},{b},{3 * a + b},{2 * (3 * a + b)}\n" for a in (1, 2, 3) for b in (1, 2, 3))
    read = trial.read_trial(text, "x.csv")
    at_odds = evaluation.evaluate_trial(
        read, requested={"Y1": ResponseGoal.parse("larger"), "Y2": ResponseGoal.parse("smaller")}
    ).result
    assert any("9 combinations of levels share the best mean rank" in warning for warning in at_odds.warnings)
    agreed = evaluation.evaluate_trial(
        read, requested={"Y1": ResponseGoal.parse("larger"), "Y2": ResponseGoal.parse("larger")}
    ).result
    assert not any("share the best" in warning for warning in agreed.warnings)
    assert agreed.best["both"] == [3, 3]


def test_equal_losses_share_a_rank_rounding_apart() -> None:
    assert evaluation.rank_losses(np.array([2.0, 1.0, 1.0 + 1e-14, 5.0])).tolist() == [3, 1.5, 1.5, 4]
    assert evaluation.order_combinations([np.array([3.0, 1, 2]), np.array([1.0, 3, 2])])[0] == 2
    with pytest.raises(InputError):
        evaluation.parse_goals(["Y=1e999"])


def test_tables_page_and_figures_say_the_goal(table: str, tmp_path: Path) -> None:
    code, out, _ = run(table, "--goal", "Y=larger", "--out", str(tmp_path / "out"))
    assert code == 0
    assert "larger" in out
    page = (tmp_path / "out" / "report.html").read_text()
    assert "<th>goal</th>" in page.replace(' scope="col"', "")
    assert "goal of Y" in page
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["goals"] == {"Y": "larger"}


def test_help_lists_goals() -> None:
    code, out, _ = run("--help")
    assert code == 0
    assert "larger, smaller, zero" in " ".join(out.split())
