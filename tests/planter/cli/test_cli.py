"""The command line against its contract: keys, exit codes, one sentence for bad input."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from planter.audit import numbers
from planter.files import examples
from planter.gears.geometry import families
from planter.papers.planting import file
from tests.support.cli import answer, refusal, run

ROOT = Path(__file__).parents[3]


def test_numbers_of_a_simulation_agree_with_each_other() -> None:
    result = answer("simulate", "wang2017", "--at", "0", "--at", "100")
    assert [row["phi_deg"] for row in result["at"]] == [0, 100]
    assert result["design"] == file.load("wang2017").design
    assert result["work"]["input_J"] == pytest.approx(result["work"]["friction_J"], abs=1e-9)
    force = result["support_force"]
    assert result["objective"] == pytest.approx(
        0.6 * force["range_N"] + 0.4 * force["variance_N2"], rel=1e-15
    )
    assert result["refined"]["max_N"] >= force["max_N"]


def test_both_models_share_kinematics_and_differ_in_forces() -> None:
    exact, printed = (
        answer("simulate wang2017 --model", m, "--at", "200")["at"][0] for m in ("exact", "printed")
    )
    same = {key for key in exact if exact[key] == pytest.approx(printed.get(key), abs=1e-9)}
    assert {"phi52_deg", "phi72_deg", "alpha_deg", "omega_rad_s", "tip_x_mm", "theta1_deg"} <= same
    assert not same & {"F_E_N", "M_Q_Nm", "support_N", "M_L_Nm", "F_B1x_N"}


def test_only_printed_model_warns_of_pulling_teeth() -> None:
    assert answer("simulate", "wang2017")["warnings"] == []
    warnings = answer("simulate", "wang2017", "--model", "printed")["warnings"]
    assert [w["name"] for w in warnings] == ["contact_would_pull"] * 2


def test_a_weak_spring_loses_the_roller_at_an_angle() -> None:
    weak = (
        "simulate",
        "wang2017",
        "--set",
        "preload_N=0",
        "--set",
        "rate_N_m=0",
        "--speed-rpm",
        "200",
    )
    result = answer(*weak)
    lost = [w for w in result["warnings"] if w["message"].startswith("F_E ")]
    assert lost
    at = answer(*weak, "--at", str(lost[0]["phi_deg"] + 0.01))
    assert at["at"][0]["F_E_N"] < 0


def test_design_outside_bounds_is_simulated_with_warning() -> None:
    result = answer("simulate wang2017 --set R3_mm=32")
    assert result["design"]["R3_mm"] == 32
    assert "R3_mm = 32 lies outside its bounds [30.46, 31.01]" in result["warnings"][-1]["message"]


def test_sensitivity_names_parameters_without_effect() -> None:
    result = answer("sensitivity wang2017")
    today = {"samples", "objective", "gradient", "effective_parameters", "insensitive"}
    assert result.keys() == today | {"machine", "kind", "least", "scaled", "combinations"}
    assert result["effective_parameters"] == 10 - len(result["insensitive"])
    assert [{"gamma_deg": 1.0}] in result["insensitive"]
    assert [{"A6_mm": 1.0}] in result["insensitive"]
    assert result["gradient"]["gamma_deg"] == pytest.approx(0, abs=1e-12)


def test_examples_are_listed_printed_and_valid(tmp_path: Path) -> None:
    names = answer("example")["examples"]
    assert {"wang2017", "compact", "shi2021", "yu2023", "sun2019"} <= set(names)
    for name in examples.list_examples("planting"):
        code, text, _ = run(f"example {name}")
        assert code == 0
        path = tmp_path / f"{name}.toml"
        path.write_text(text)
        assert answer(f"validate {path}")["valid"] is True


BAD = {
    "no such machine": (("simulate", "wang2071"), r"did you mean wang2017\?"),
    "no such file": (("simulate", "nowhere.toml"), r"nowhere\.toml"),
    "no number": (
        ("simulate", "wang2017", "--set", "sun_kg=heavy"),
        r"--set sun_kg=heavy: it must be NAME=VALUE",
    ),
    "no value": (("simulate", "wang2017", "--set", "sun_kg"), r"it must be NAME=VALUE"),
    "unknown name": (("simulate", "wang2017", "--set", "sum_kg=1"), r"sum_kg .*did you mean"),
    "negative mass": (
        ("validate", "wang2017", "--set", "sun_kg=-0.4"),
        r"mass\.sun_kg = -0\.4.*greater than 0",
    ),
    "speed of zero": (
        ("simulate", "wang2017", "--speed-rpm", "0"),
        r"speed_rpm = 0.*greater than 0",
    ),
    "too few samples": (
        ("simulate", "wang2017", "--samples", "3"),
        r"--samples = 3: it must be between 4",
    ),
    "angle that is no number": (("simulate", "wang2017", "--at", "nan"), r"--at = nan:"),
    "eccentricity": (
        ("simulate", "wang2017", "--set", "e3_mm=31"),
        r"design\.e3_mm = 31.*less than R",
    ),
    "samples that are no number": (
        ("optimise", "wang2017", "--samples", "many"),
        r"--samples = many.*refined",
    ),
    "unknown target": (("calibrate", "wang2017", "--target", "table2"), r"did you mean table1\?"),
    "decimal comma": (("validate", "wang2017", "--set", "sun_kg=0,4"), r"decimal point: 0\.4"),
    "output into a file": (("simulate", "wang2017", "--out", "/dev/null/x"), r"/dev/null/x"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_refused_in_a_sentence(case: str) -> None:
    arguments, sentence = BAD[case]
    assert re.search(sentence, refusal(*arguments))


WRONG_FILES = {
    "text.toml": ("hello world\n", r"text\.toml: line 1, column 7: .*TOML"),
    "empty.toml": ("", r"empty\.toml: .* no tables"),
    "twice.toml": ("[design]\n[design]\n", r"twice\.toml: line 2"),
    "other.toml": ("[crop]\nrows = 2\n", r"other\.toml: .*crop.*planter new"),
    "statement.py": ("x = 1\n", r"`planter derive statement\.py` writes one"),
}
"""Files that are no machines by name, each with what is said of it."""


@pytest.mark.parametrize("name", WRONG_FILES)
@pytest.mark.parametrize("command", ["simulate", "animate"])
def test_file_that_is_no_machine_is_refused_with_its_fault(
    command: str, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    text, sentence = WRONG_FILES[name]
    Path(name).write_text(text)
    assert re.search(sentence, refusal(command, name))


@pytest.mark.parametrize(
    ("call", "words"),
    [
        ("simulate wang2017 --samples ten", ("--samples", "ten", "integer")),
        ("simulate wang2017 --model both", ("--model", "both", "'exact', 'printed'")),
        ("optimise wang2017 --starts 0", ("--starts", "0", "1")),
        ("gears wang2017 --module 100", ("--module", "100", "50")),
        ("cam wang2017", ("--roller-mm", "`planter cam --help`")),
        ("export d wang2017", ("'d'", "`planter export --help`")),
        ("simulate wang2017 more", ("more", "`planter simulate --help`")),
    ],
)
def test_refused_call_names_value_and_what_is_allowed(call: str, words: tuple[str, ...]) -> None:
    message = refusal(call)
    assert not [word for word in words if word not in message]
    assert "Value error" not in message


def test_folder_of_results_that_is_a_file_is_named(tmp_path: Path) -> None:
    file = tmp_path / "results"
    file.touch()
    assert f"{file}: this is a file" in refusal("simulate", "wang2017", "--out", str(file))


def test_page_is_named_if_it_was_written(tmp_path: Path) -> None:
    call = ("design clutch geometry shi2021", "--out", str(tmp_path))
    assert run(*call)[2].endswith(f"report: {tmp_path / 'report.html'}\n")
    assert "report:" not in run(*call, "--json")[2]


@pytest.mark.parametrize(
    "arguments",
    [
        ("simulate",),
        ("frobnicate",),
        ("simulate", "wang2017", "--model", "both"),
        ("optimise", "wang2017", "--starts", "0"),
        ("simulate", ""),
        ("simulate", "wang2017", "--speed-rpm", "1,5"),
    ],
)
def test_misunderstood_call_is_refused_in_a_sentence(arguments: tuple[str, ...]) -> None:
    message = refusal(*arguments)
    assert message.startswith("planter: ")
    assert not message.startswith("planter: :")
    assert ("with a decimal point: 1.5" in message) == ("1,5" in arguments)


@pytest.fixture(scope="module")
def simulated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a simulation, its figures drawn; tests that write work on a copy."""
    folder = tmp_path_factory.mktemp("simulated") / "run"
    answer(f"simulate wang2017 --out {folder}")
    return folder


def test_output_files(simulated: Path) -> None:
    summary = json.loads((simulated / "summary.json").read_text())
    rows = [
        line
        for line in (simulated / "values.csv").read_text().splitlines()
        if not line.startswith("#")
    ]
    table = np.genfromtxt(rows, delimiter=",", names=True)
    assert len(table) == 360
    assert table["support_N"].max() == summary["support_force"]["max_N"]
    assert (simulated / "report.html").read_text().startswith("<!DOCTYPE html>")
    assert {p.suffix for p in simulated.rglob("*")} >= {".json", ".csv", ".html", ".svg", ".png"}


def test_optimum_of_the_printed_model_is_worse_in_the_exact_one() -> None:
    result = answer(
        "optimise wang2017 --model printed --method ipopt --starts 1 --samples 90",
    )
    assert result["certificate"]["kkt_residual"] < 1e-6
    scores = result["cross"]
    assert scores["printed"]["start"] == pytest.approx(result["start_objective"], rel=1e-12)
    assert scores["printed"]["optimum"] == pytest.approx(result["objective"], rel=1e-12)
    assert result["objective"] < result["start_objective"]
    assert scores["exact"]["optimum"] > scores["exact"]["start"]
    bounds = file.load("wang2017").bounds
    assert all(
        bounds[name][0] <= value <= bounds[name][1] for name, value in result["design"].items()
    )


def test_reused_folder_has_no_earlier_figures(simulated: Path, tmp_path: Path) -> None:
    folder = shutil.copytree(simulated, tmp_path / "run")
    (folder / "notes.txt").write_text("own")
    assert list(folder.glob("figures/*.svg"))
    answer(f"sensitivity wang2017 --out {folder}")
    assert {path.name for path in folder.iterdir()} == {
        "notes.txt",
        "summary.json",
        "report.html",
        ".planter.json",
    }


@pytest.mark.parametrize(
    ("arguments", "hint"),
    [
        (
            ("simulate", "--help"),
            ("planter example", "mass.sun_kg", "hinge_A_mm[0]", "exact", "printed"),
        ),
        (("calibrate", "--help"), ("table1",)),
        (("optimise", "--help"), ("hybrid", "ipopt", "ga")),
        (("audit", "--help"), tuple(numbers.list_papers())),
        (("compare", "--help"), tuple(families.list_families())),
    ],
)
def test_help_says_where_names_stand_and_lists_every_choice(
    arguments: tuple[str, ...], hint: tuple[str, ...]
) -> None:
    code, out, _ = run(*arguments)
    assert code == 0
    words = re.sub(r"(?<=\w-) ", "", " ".join(out.split()))  # lines may break after a hyphen
    for word in hint:
        assert word in words


@pytest.mark.parametrize(
    ("arguments", "hint"),
    [
        (
            ("pickup", "yu2023", "--set", "phi5_far_deg=1e15"),
            "law.phi5_far_deg = 1000000000000000.0",
        ),
        (("validate", "n" * 5000), "there is no built-in machine of that name"),
        (("simulate", "n" * 5000), "there is no built-in machine of that name"),
        (("validate", "no\nsuch.toml"), r"no\nsuch.toml: there is no such file"),
        (("validate", "wang2017", "--set", "x" * 9_000 + "=1"), "the file has no such value"),
        (("validate", "wang2017", "--set", "x" * 100_000 + "=1"), "is too long"),
        (("validate", "wang2017", "--set", "\x1b[31m=1"), r"\u001b[31m"),
        (("synthesise", "shi2021"), "this is a built-in TOML file for planter design clutch"),
        (("train", "sun2019"), "sun2019-curve or the path of a .csv file"),
    ],
)
def test_strange_input_is_refused_in_a_printable_sentence(
    arguments: tuple[str, ...], hint: str
) -> None:
    message = refusal(*arguments)
    assert hint in message
    assert message.isprintable()
    assert len(message) < 1600


def test_non_utf_8_file_name_is_accepted(tmp_path: Path) -> None:
    path = os.fsencode(tmp_path) + b"/w\xff.toml"
    with open(path, "w", encoding="utf-8") as file_:
        file_.write(examples.example("compact"))
    done = subprocess.run(
        [sys.executable, "-m", "planter", "sensitivity", path, "--out", tmp_path / "out"],
        cwd=ROOT,
        capture_output=True,
        check=False,
    )
    assert (done.returncode, done.stderr.count(b"\n")) == (0, 1)
    assert json.loads((tmp_path / "out" / "summary.json").read_text(encoding="utf-8"))
    assert r"w\udcff.toml: mass.sun_kg = -1.0" in refusal(
        "validate", os.fsdecode(path), "--set", "sun_kg=-1"
    )
