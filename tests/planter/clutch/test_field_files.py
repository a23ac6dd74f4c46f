"""The commands `clutch field` and `clutch plan`, and the files that they leave."""

from __future__ import annotations

import csv
import json
import re
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest

from planter.clutch.field import evaluate_field, evaluation, presentation, trial
from planter.clutch.field.analysis import MainEffectsModel
from planter.files import examples
from tests.support.cli import below

GOALS = ("--goal", "Y1=zero", "--goal", "Y2=0")
KEYS = {"range", "anova", "goals", "best", "prediction", "comparison"}


run, answer, refusal = below("clutch")


def rows_of(path: Path) -> list[dict[str, str]]:
    return list(
        csv.DictReader(line for line in path.read_text().splitlines() if not line.startswith("#"))
    )


def test_field_has_the_keys_of_the_contract() -> None:
    result = answer("field")
    assert result.keys() >= KEYS
    assert result == answer("field", "shi2021-field")
    assert len(result["range"]["Y1"]["A"]["k"]) == 3
    assert result["anova"]["Y1"]["A"].keys() == {"ss", "df", "ms", "F", "p"}
    assert list(result["anova"]["Y2"]) == ["A", "B", "C", "error", "total"]
    assert [row.keys() for row in result["prediction"]] == [{"levels", "Y1", "Y2"}] * 27
    assert all(
        row.keys() >= {"speed_m_s", "measure", "reduction_percent", "p_value"}
        for row in result["comparison"]
    )
    assert len(result["comparison"]) == 6


def test_user_file_needs_statistics_for_comparison(tmp_path: Path) -> None:
    path, statistics = tmp_path / "mine.csv", tmp_path / "clutches.csv"
    path.write_text(examples.example("shi2021-field"))
    statistics.write_text(examples.example("shi2021-comparison"))
    user_result, paper = answer("field", str(path), *GOALS), answer("field")
    assert user_result["comparison"] == user_result["other_comparisons"] == []
    assert user_result["anova"] == paper["anova"]
    assert (
        answer("field", str(path), *GOALS, "--comparison", str(statistics))["comparison"]
        == paper["comparison"]
    )
    assert (
        answer("field", str(path), *GOALS, "--comparison", "shi2021-comparison")["comparison"]
        == paper["comparison"]
    )


def test_tables_for_a_person_and_notes_for_an_unbalanced_design(tmp_path: Path) -> None:
    code, out, _ = run("field")
    assert code == 0
    assert all(
        text in out
        for text in ("Range analysis", "183.828", "**", "reuleaux against jaw", "82.3529")
    )
    factor_20_degrees = r"axial angle \(A\) / ° +20 +3\.26667"  # level 3 by its value
    assert re.search(factor_20_degrees, out)
    path = tmp_path / "rest.csv"
    path.write_text("".join(examples.example("shi2021-field").splitlines(keepends=True)[:-1]))
    code, out, _ = run("field", str(path), *GOALS)
    assert code == 0
    assert "Range analysis" not in out
    assert "type II" in out


def test_bad_calls_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "bad.csv"
    path.write_text(examples.example("shi2021-field").replace("12.2", "twelve"))
    assert refusal("field", str(path)).startswith(f"planter: {path}: line 10, column Y1: 'twelve':")
    assert "nowhere.csv" in refusal("field", "nowhere.csv")
    assert "did you mean shi2021-field" in refusal("field", "shi2021-feild")
    assert "--response Y9: shi2021-field has no such column" in refusal("field", "--response", "Y9")
    assert "L10: there is no plan" in refusal("plan", "L10")
    assert "the header 'run,A,B,C,blank,Y1,Y2': it must be clutch,speed" in refusal(
        "field", "--comparison", "shi2021-field"
    )
    path.write_text("")
    assert "the file is empty" in refusal("field", str(path))
    assert "cannot be written" in refusal("field", "--out", str(path))


def test_a_plan_is_printed_and_written(tmp_path: Path) -> None:
    arguments = (
        "plan",
        "L9",
        "--factor",
        "angle_deg=10,15,20",
        "--factor",
        "k=0.3,0.4,0.5",
        "--seed",
        "4",
    )
    code, out, _ = run(*arguments, "--out", str(tmp_path))
    assert code == 0
    assert (tmp_path / "plan.csv").read_text() == out
    result = answer(*arguments, "--response", "Y1", "--response", "Y2")
    assert list(result["columns"]) == ["run", "angle_deg", "k", "blank1", "blank2", "Y1", "Y2"]
    assert sorted(result["columns"]["k"]) == ["0.3"] * 3 + ["0.4"] * 3 + ["0.5"] * 3
    assert "column Y1: it is empty" in refusal("field", str(tmp_path / "plan.csv"))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("field")
    presentation.present_field_test(evaluate_field()).write(out)
    return out


def test_files_hold_the_result(folder: Path) -> None:
    result = evaluate_field().result
    summary = json.loads((folder / "summary.json").read_text())
    assert len(summary.pop("provenance")["data_sha256"]) == 64
    assert summary == json.loads(json.dumps(result.table()))
    anova = {(row["response"], row["source"]): row for row in rows_of(folder / "anova.csv")}
    assert len(anova) == 10
    assert float(anova["Y2", "B"]["F"]) == result.anova["Y2"]["B"].F
    assert anova["Y1", "total"]["F"] == anova["Y1", "error"]["p"] == ""
    predicted = [
        [float(row[name]) for name in ("A", "B", "C", "Y1", "Y2")]
        for row in rows_of(folder / "prediction.csv")
    ]
    assert predicted == [
        [*row.levels, row.means["Y1"], row.means["Y2"]] for row in result.prediction
    ]
    assert [float(row["k"]) for row in rows_of(folder / "range.csv")][:3] == result.range["Y1"][
        "A"
    ].k
    assert len(rows_of(folder / "comparison.csv")) == 10


def test_the_page_is_whole_and_every_figure_is_there(folder: Path) -> None:
    text = (folder / "report.html").read_text()
    ElementTree.fromstring(text.replace("<!DOCTYPE html>", ""))
    assert all(word in text for word in ("183.828", "axial angle / °", "qualified percent"))
    for name in ("effects", "surface_Y1", "surface_Y2", "comparison"):
        assert (folder / "figures" / f"{name}.png").read_bytes()[:4] == b"\x89PNG"
        ElementTree.parse(folder / "figures" / f"{name}.svg")
    assert text.count("<figure>") == 4


def test_other_data_have_another_hash() -> None:
    text = examples.example("shi2021-field")
    first, same, other = (
        presentation.present_field_test(
            evaluation.evaluate_trial(trial.read_trial(t, "x.csv"))
        ).summary()
        for t in (text, "# a comment\n" + text, text.replace("12.2", "12.3"))
    )
    first, same, other = (summary["provenance"]["data_sha256"] for summary in (first, same, other))
    assert first == same != other


def test_names_of_any_kind_are_drawn_and_escaped(tmp_path: Path) -> None:
    text = (
        "# factor a$b: cost / $ = 1, 3\n# response Y$: <b> & $\n"
        + '"a$b",B,D,Y$,Y/2\n'
        + "".join(
            f"{i % 2},{'lo<w' if i // 2 % 2 else '$'},{i // 4 % 2},{i * i + 0.5 * (i % 3)},{-i}\n"
            for i in range(8)
        )
    )
    path = tmp_path / "odd.csv"
    path.write_text(text)
    assert (
        run(
            "field",
            str(path),
            "--out",
            str(tmp_path / "out"),
            "--goal",
            "Y$=larger",
            "--goal",
            "Y/2=smaller",
        )[0]
        == 0
    )
    report = (tmp_path / "out" / "report.html").read_text()
    ElementTree.fromstring(report.replace("<!DOCTYPE html>", ""))
    assert "lo&lt;w" in report
    assert (tmp_path / "out" / "figures" / "surface_1.svg").exists()


def test_surfaces_pass_through_the_prediction_at_every_level() -> None:
    surfaces = evaluate_field()
    for response in surfaces.trial.responses:
        effects = MainEffectsModel(surfaces.trial).effects(response)
        for factor, level in zip(surfaces.trial.factors, effects.levels, strict=True):
            knots = np.array(factor.scale)
            assert presentation.interpolate_effect(knots, level, knots) == pytest.approx(
                level, abs=1e-12
            )
            middle = presentation.interpolate_effect(
                knots, level, np.array([(knots[0] + knots[1]) / 2])
            )
            parabola = np.polyval(np.polyfit(knots, level, 2), (knots[0] + knots[1]) / 2)
            assert middle == pytest.approx(parabola, abs=1e-10)
    many = np.array([0.0, 1.0, 0.0, 0.5, 5.0])
    dense = presentation.interpolate_effect(np.arange(5.0), many, np.linspace(0, 4, 401))
    assert (dense.min(), dense.max()) == (0, 5)


def test_command_line_defers_heavy_imports() -> None:
    heavy = "('matplotlib', 'scipy')"
    code = f"import sys, planter.cli; print([name for name in {heavy} if name in sys.modules])"
    assert (
        subprocess.run(
            [sys.executable, "-c", code], capture_output=True, text=True, check=True
        ).stdout
        == "[]\n"
    )
