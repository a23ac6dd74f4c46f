"""`planter calibrate` without data: the inputs that were searched for a paper's figures."""

from pathlib import Path

import pytest

from planter.papers.planting import calibration
from tests.support.cli import answer, refusal, run

THEORY = {"max_N": 158.94, "min_N": 36.77, "variance_N2": 1907.32}
KEYS = {"fitted", "target", "reached", "rank", "other_model", "met", "choices"}


@pytest.mark.parametrize(("model", "is_met"), [("printed", True), ("exact", False)])
def test_fit_is_that_of_the_simulated_inputs(model: str, is_met: bool, tmp_path: Path) -> None:
    result = answer(f"calibrate wang2017 --model {model} --target table1")
    assert result.keys() >= KEYS
    assert (result["target"], result["met"], result["rank"]) == (THEORY, is_met, 3)
    assert all(row["lower"] <= row["value"] <= row["upper"] for row in result["fitted"])
    misses = {key: 100 * (result["reached"][key] / value - 1) for key, value in THEORY.items()}
    assert result["miss_percent"] == pytest.approx(misses)
    assert is_met is (max(map(abs, misses.values())) <= 1)
    assert ("front" in result) is not is_met
    file = tmp_path / "fitted.toml"
    flank = result["choices"]["cam.flank"]
    file.write_text(run("example wang2017")[1].replace("4-5-6-7 polynomial", flank), "utf-8")
    inputs = [f"--set {row['name']}={row['value']!r}" for row in result["fitted"]]
    other = {"printed": "exact", "exact": "printed"}[model]
    forces = {
        each: answer(f"simulate {file} --model {each} {' '.join(inputs)}")["support_force"]
        for each in (model, other)
    }
    assert {key: forces[model][key] for key in THEORY} == pytest.approx(result["reached"], rel=1e-9)
    expected = {key: forces[other][key] for key in ("range_N", "variance_N2")}
    assert {key: result["other_model"][key] for key in expected} == pytest.approx(expected)


def test_tampered_record_is_not_met(monkeypatch: pytest.MonkeyPatch) -> None:
    inputs = calibration.load_study()["targets"]["table1"]["fits"]["printed"]["inputs"]
    monkeypatch.setitem(inputs, "mass.carrier_kg", inputs["mass.carrier_kg"] + 1)
    assert not answer("calibrate wang2017")["met"]


def test_terminal_says_whether_the_target_is_met() -> None:
    for model, words in (("printed", "is met by the printed"), ("exact", "is missed by the exact")):
        text = " ".join(run(f"calibrate wang2017 --model {model}")[1].split())
        assert f"{words} model" in text


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("wang2017 --target table2", "--target = table2: did you mean table1"),
        ("wang2017 --set mass.sun_kg=0.5", "searched for wang2017 alone"),
        ("compact", "searched for wang2017 alone"),
    ],
)
def test_what_was_not_searched_for_is_refused(words: str, message: str) -> None:
    assert message in refusal(f"calibrate {words}")
