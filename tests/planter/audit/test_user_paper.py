"""Papers and texts of a user: verdicts, laws, numbers, page; errors in a file by their place; the
benchmark.
"""

from __future__ import annotations

import json
import re
import shutil
import tomllib
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest

from planter.audit import numbers as judge
from planter.audit import user_paper
from planter.audit.equation_page import list_changes
from planter.audit.registry import Inputs
from planter.errors import InputError
from planter.mechanism import printed
from planter.mechanism.model import Model
from tests.derive.audit.texts.test_benchmark import write_text
from tests.support import own
from tests.support.cli import answer, refusal, run
from tests.support.schemas import load_schema

FILES = ("slider_crank.py", "slider_crank_paper.py", "slider_crank_numbers.toml")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("own")
    for name in FILES:
        shutil.copy(own.EXAMPLES / name, place)
    return place


@pytest.fixture(scope="module")
def result(folder: Path) -> Any:
    """The audit of the example, with its page in `trial`."""
    paper, numbers = folder / "slider_crank_paper.py", folder / "slider_crank_numbers.toml"
    return answer(f"audit {paper} --numbers {numbers} --out", str(folder / "trial"))


def test_example_is_judged_with_planted_errors(result: Any) -> None:
    jsonschema.validate(result, load_schema("audit"))
    wrong = {
        e["equation"]: e["verdict"] for e in result["equations"] if e["verdict"] != "confirmed"
    }
    assert wrong == {"2": "misprint", "4": "misprint", "5": "incomplete"}
    (number,) = [n for n in result["numbers"] if n["verdict"] not in ("reproduced", "consistent")]
    assert (number["place"], number["quantity"], number["verdict"]) == (
        "Table 1, second row",
        "range s",
        "not reproduced",
    )
    assert number["difference"] == pytest.approx(number["recomputed"] - 101.03)
    assert {law["caused_by"][0] for law in result["laws"] if law["violation"]} == {"4"}
    (summary,) = result["summary"].values()
    assert summary["numbers"] == {"consistent": 2, "not reproduced": 1, "reproduced": 6}


def test_stroke_equals_geometry(result: Any) -> None:
    """An offset slider-crank: its ends are where crank and rod lie in line."""
    ends = [((200 + sign * 50) ** 2 - 10**2) ** 0.5 for sign in (1, -1)]
    stroke = next(n["recomputed"] for n in result["numbers"] if n["quantity"] == "range s")
    assert stroke == pytest.approx(ends[0] - ends[1], rel=1e-12)


def test_assumed_inputs_are_listed_for_dependent_numbers(result: Any) -> None:
    felt = {n["quantity"]: n["assumed_inputs"] for n in result["numbers"]}
    assert felt["max abs F_Ax"] == felt["mean P_guide"] == ["mu = 0.1"]
    assert felt["max s"] == felt["beta at 90"] == []


def test_digits_of_disclosed_values_bound_a_number(folder: Path, result: Any) -> None:
    """A crank of 50.0 mm leaves 0.1 mm of the stroke open, one of 50 mm or 50.000 mm less than its
    last digit.
    """
    verdicts = {}
    for text in ("50", "50.0", "50.000"):
        source = folder / "rounded.toml"
        stated = (folder / "slider_crank_numbers.toml").read_text(encoding="utf-8")
        source.write_text(
            stated.replace("r_mm = 50", f"r_mm = {text}").replace('"101.03"', '"100.20"'),
            encoding="utf-8",
        )
        read = user_paper.read_numbers_file(source)
        rows = [
            row
            for row in user_paper.list_rows(
                read, source, "p", folder / "generated" / "slider_crank.toml"
            )
            if row["quantity"] == "range s"
        ]
        table = {"disclosed": {"p": read.disclosed}, "assumed": {"p": read.assumed}, "number": rows}
        verdicts[text] = judge.judge_numbers("p", table)[0]["verdict"]
    assert verdicts == {"50": "not reproduced", "50.0": "consistent", "50.000": "not reproduced"}


def test_a_row_of_numbers_holds_for_the_values_of_each(result: Any) -> None:
    rows = [n for n in result["numbers"] if n["quantity"] == "max abs a_rod_x"]
    assert [n["place"] for n in rows] == ["Table 3, 300 r/min", "Table 3, 600 r/min"]
    assert rows[1]["recomputed"] == pytest.approx(4 * rows[0]["recomputed"], rel=1e-12)


def test_verdicts_are_in_file_and_page(folder: Path, result: Any) -> None:
    written = {path.name for path in (folder / "generated").iterdir()}
    assert written >= {
        "audit.json",
        "audit_mathml.json",
        "verdicts.json",
        "AUDIT.md",
        "slider_crank.toml",
        "slider_crank.py",
    }
    text = (folder / "trial" / "report.html").read_text(encoding="utf-8")
    root = ET.fromstring(text.removeprefix("<!DOCTYPE html>\n"))
    assert not re.search(r"<script|<link|src=|url\(|http://", text)
    assert len(list(root.iter("math"))) >= len(result["equations"])
    page_text = " ".join(" ".join(root.itertext()).split())
    for entry in result["numbers"]:
        assert entry["place"].replace(" deg", "°") in page_text
    assert "differs by" in page_text
    assert (
        json.loads((folder / "trial" / "summary.json").read_text(encoding="utf-8"))["numbers"]
        == result["numbers"]
    )


def numbers(folder: Path, change: tuple[str, str]) -> Path:
    text = (folder / "slider_crank_numbers.toml").read_text(encoding="utf-8")
    assert change[0] in text
    (folder / "changed.toml").write_text(text.replace(*change, 1), encoding="utf-8")
    return folder / "changed.toml"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (('"max s"', '"max ss"'), r"number\[0\]\.quantity = 'max ss': .* did you mean s\?"),
        (('"max s"', '"s"'), r"number\[0\]\.quantity = 's': .*it must be MEASURE"),
        (('"max s"', '"s at 2 s"'), r"number\[0\]: s at 2 s: an angle drives slider_crank"),
        (('unit = "mm"', 'unit = "N"'), r"number\[0\]\.unit = 'N': max s is in m"),
        (('unit = "mm"', 'unit = "ell"'), r"number\[0\]\.unit = 'ell': ell is not a unit"),
        (("mu = 0.1", "muu = 0.1"), r"assumed\.muu: .* did you mean mu\?"),
        (
            ("{ omega_rpm = [300, 600] }", "{ omega_rpm = [300, 600], r = [1, 2] }"),
            r"number\[3\]\.each\.r",
        ),
    ],
)
def test_meaningless_number_is_refused_with_place(
    folder: Path, result: Any, change: tuple[str, str], message: str
) -> None:
    source = numbers(folder, change)
    rows = user_paper.list_rows(
        user_paper.read_numbers_file(source),
        source,
        "invented2026",
        folder / "generated" / "slider_crank.toml",
    )
    with pytest.raises(InputError, match=message):
        _ = [printed.measure(Inputs(row["with"], {}, {})) for row in rows]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (('place = "Table 1, first row"\n', ""), "number[0].place is missing"),
        (
            ('printed = "249.8"', "printed = 249.8"),
            "number[0].printed = 249.8: it must be text in quotes",
        ),
        (('"249.8"', '"249,8"'), "with a decimal point"),
        (
            ('["54.31", "217.22"]', '["54.31"]'),
            "number[3].each.omega_rpm = [300, 600]: it must have as many entries",
        ),
        (('"beta at {phi}"', '"beta at {psi}"'), "number[2]: 'beta at {psi}': it may hold {phi}"),
        (("mu = 0.1", "r_mm = 50"), "assumed.r_mm = 50.0: the paper discloses it"),
        (("[assumed]", "[asumed]"), "did you mean assumed?"),
    ],
)
def test_invalid_numbers_file_is_refused(
    folder: Path, change: tuple[str, str], message: str
) -> None:
    source = numbers(folder, change)
    with pytest.raises(InputError) as error:
        list(user_paper.list_rows(user_paper.read_numbers_file(source), source, "p", folder))
    assert message in str(error.value)


@pytest.mark.long
def test_wrong_equation_without_claim_has_a_single_line(folder: Path) -> None:
    text = (folder / "slider_crank_paper.py").read_text(encoding="utf-8")
    claim = '    m.balance(bodies["rod"], "moment"),\n'
    assert text.count(claim) == 1
    (folder / "unclaimed_paper.py").write_text(text.replace(claim, ""), encoding="utf-8")
    result = answer("audit", str(folder / "unclaimed_paper.py"))
    equations = {e["equation"]: e for e in result["equations"]}
    assert {
        number: e["verdict"] for number, e in equations.items() if e["verdict"] != "confirmed"
    } == {
        "2": "misprint",
        "4": "misprint",
        "5": "contradicted",
    }
    assert equations["5"]["reasons"] == ["(5) does not hold"]
    jsonschema.validate(result, load_schema("audit"))


def test_number_without_value_has_a_single_line(folder: Path, result: Any) -> None:
    """A rod that is shorter than the crank: the loop does not close."""
    source = numbers(folder, ('printed = "249.8"', 'printed = "249.8"\nwith = { l_mm = 20 }'))
    papers = {"invented2026": {"model": "slider_crank"}}
    judged = user_paper._judge_file(
        user_paper.read_numbers_file(source), source, papers, folder / "generated"
    )
    assert [(number["verdict"], number["recomputed"]) for number in judged[:1]] == [
        ("not recomputable", None)
    ]
    assert "do not close" in judged[0]["reason"]
    others_judged = [(number["quantity"], number["recomputed"]) for number in judged[1:]]
    assert others_judged == [
        (number["quantity"], number["recomputed"]) for number in result["numbers"][1:]
    ]


def test_other_paper_is_not_confused(folder: Path) -> None:
    source = numbers(folder, ("[disclosed]", 'paper = "invented2025"\n[disclosed]'))
    papers: dict[str, Any] = {"invented2026": {}, "another": {}}
    with pytest.raises(InputError, match=r"paper = 'invented2025': did you mean invented2026\?"):
        user_paper.find_paper(user_paper.read_numbers_file(source), source, papers)
    unnamed = folder / "slider_crank_numbers.toml"
    with pytest.raises(
        InputError, match="paper is missing: it must be one of invented2026, another"
    ):
        user_paper.find_paper(user_paper.read_numbers_file(unnamed), unnamed, papers)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            ('loop("By")', 'loop("Bq")'),
            "invented2026 (2): nothing here states 'the loop Bq closes'; near it",
        ),
        (("q.e - q.r", "q.ee - q.r"), "line 25: AttributeError: there is no quantity ee"),
    ],
)
def test_error_raised_by_paper_names_user_line(
    folder: Path, change: tuple[str, str], message: str
) -> None:
    text = (folder / "slider_crank_paper.py").read_text(encoding="utf-8")
    assert change[0] in text
    (folder / "wrong_paper.py").write_text(text.replace(*change), encoding="utf-8")
    code, out, err = run("audit", str(folder / "wrong_paper.py"), "--json")
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert "wrong_paper.py, line" in err
    assert message in err


def test_options_of_other_papers_are_refused(folder: Path) -> None:
    source = str(folder / "slider_crank_numbers.toml")
    assert "--numbers" in refusal(f"audit wang2017 --numbers {source}")
    assert "define CASE" in refusal("audit", str(folder / "slider_crank.py"))
    assert "there is no such file" in refusal("audit", str(folder / "nowhere.py"))


SENSOR = """[measurement]
quantity = "F_Ox"
drive = "M_in"
lever_mm = 80.0

"""


def judge_sensor(folder: Path, sensor: str, quantity: str, printed_text: str) -> dict[str, Any]:
    """Return the verdict on one number of the example's mechanism behind a sensor."""
    source = folder / "sensor.toml"
    number = (
        f'[[number]]\nplace = "page 9"\nquantity = "{quantity}"\nunit = "N"\nprinted = '
        f'"{printed_text}"\n'
    )
    source.write_text(f"{sensor}{number}", encoding="utf-8")
    read = user_paper.read_numbers_file(source)
    rows = list(user_paper.list_rows(read, source, "p", folder / "generated" / "slider_crank.toml"))
    table = {"disclosed": {"p": read.disclosed}, "assumed": {"p": read.assumed}, "number": rows}
    (verdict,) = judge.judge_numbers("p", table)
    return verdict


@pytest.mark.usefixtures("result")
def test_number_of_a_sensor_is_that_of_its_signal(folder: Path) -> None:
    """The force with the torque at a lever, by the machine's own results; the rigid force is the
    tampered case.
    """
    rigid = Model(own.machine("slider_crank")).results(
        np.linspace(0, 2 * np.pi, 7200, endpoint=False)
    )
    signal = rigid["F_Ox_N"] + rigid["M_in_Nm"] / 0.080
    for quantity, expected in (
        ("max measured_F_Ox", signal.max()),
        ("range measured_F_Ox", np.ptp(signal)),
        ("max abs measured_F_Ox", np.abs(signal).max()),
        ("measured_F_Ox at 90", signal[1800]),
    ):
        verdict = judge_sensor(folder, SENSOR, quantity, f"{expected:.1f}")
        assert verdict["recomputed"] == pytest.approx(expected, rel=2e-3), quantity
    largest = rigid["F_Ox_N"].max()
    assert judge_sensor(folder, SENSOR, "max F_Ox", "1.0")["recomputed"] == pytest.approx(
        largest, rel=1e-3
    )
    assert abs(signal.max() - largest) > 0.1 * np.ptp(signal)


@pytest.mark.usefixtures("result")
@pytest.mark.parametrize(
    ("sensor", "quantity", "message"),
    [
        ("", "max measured_F_Ox", r"no quantity measured_F_Ox"),
        (SENSOR.replace("M_in", "M_inn"), "max measured_F_Ox", r"sensor\.toml: measurement\.drive"),
        (
            SENSOR.replace("lever_mm", "lever_m"),
            "max measured_F_Ox",
            r"measurement\.lever_m.* lever_mm",
        ),
        (SENSOR, "work measured_F_Ox", r"work measured_F_Ox: .*variance"),
    ],
)
def test_number_without_its_sensor_is_refused(
    folder: Path, sensor: str, quantity: str, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        judge_sensor(folder, sensor, quantity, "1.0")


TEXT = (own.EXAMPLES / "slider_crank_text.tex").read_text(encoding="utf-8")
NAMES = (own.EXAMPLES / "slider_crank_text.names.toml").read_text(encoding="utf-8")
"""What docs/text.md shows."""


@pytest.fixture(scope="module")
def text_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("text")
    shutil.copy(own.EXAMPLES / "slider_crank.py", place)
    (place / "crank.tex").write_text(TEXT, encoding="utf-8")
    (place / "complete.toml").write_text(NAMES, encoding="utf-8")
    return place


def audit_text(text_folder: Path, *options: str) -> Any:
    return answer(
        "audit",
        str(text_folder / "crank.tex"),
        "--against",
        str(text_folder / "slider_crank.py"),
        *options,
    )


@pytest.fixture(scope="module")
def text_result(text_folder: Path) -> Any:
    return audit_text(
        text_folder,
        "--names",
        str(text_folder / "complete.toml"),
        "--out",
        str(text_folder / "trial"),
    )


def line_of(words: str) -> int:
    return TEXT[: TEXT.index(words)].count("\n") + 1


def test_each_row_is_read_or_refused_at_its_line(text_result: Any) -> None:
    jsonschema.validate(text_result, load_schema("audit"))
    starts = [r"s &= r", r"r\sin", r"\dot s &=", r"l\dot\beta\cos", "T &=", "F_1 ="]
    assert [row["line"] for row in text_result["rows"]] == [line_of(start) for start in starts]
    assert [row["status"] for row in text_result["rows"]] == ["read"] * 5 + ["refused"]
    assert [bool(row["reason"]) for row in text_result["rows"]] == [False] * 5 + [True]


def test_wrong_sign_is_corrected_in_the_source(text_result: Any) -> None:
    verdicts = {e["equation"]: e["verdict"] for e in text_result["equations"]}
    assert verdicts == {
        "eq:s": "confirmed",
        "2": "confirmed",
        "eq:v": "misprint",
        "4": "confirmed",
        "7": "confirmed",
    }
    (wrong,) = [e for e in text_result["equations"] if e["corrected_latex"]]
    assert (wrong["equation"], wrong["file"], wrong["line"]) == (
        "eq:v",
        "crank.tex",
        line_of(r"\dot s &="),
    )
    changes = [
        (mark, text)
        for mark, text in list_changes(wrong["latex"], wrong["corrected_latex"])
        if mark != " "
    ]
    assert changes == [("-", "+"), ("+", "-")]
    assert wrong["latex"] in TEXT


def test_correction_is_marked_on_the_page(text_folder: Path, text_result: Any) -> None:
    page = (text_folder / "trial" / "report.html").read_text(encoding="utf-8")
    assert r"\varphi <del>+</del><ins>-</ins> l\dot" in page
    line = line_of(r"\dot s &=")
    assert f"crank.tex, line {line}" in page


def test_skeleton_lists_names_and_is_never_replaced(text_folder: Path) -> None:
    text = audit_text(text_folder)
    skeleton = text_folder / "crank.names.toml"
    names = tomllib.loads(skeleton.read_text(encoding="utf-8"))["names"]
    assert names[r"\varphi"] == names[r"\phi"] == "phi"
    assert names["T"] == names["v_{C}"] == ""
    assert [row["status"] for row in text["rows"]] == ["read"] * 5 + ["refused"]
    unjudged = {
        e["equation"]: e["finding"] for e in text["equations"] if e["verdict"] == "not judged"
    }
    assert unjudged.keys() == {"7"}
    assert "T" in unjudged["7"]
    skeleton.write_text("# mine\n", encoding="utf-8")
    audit_text(text_folder)
    assert skeleton.read_text(encoding="utf-8") == "# mine\n"


def test_error_in_a_names_file_is_one_sentence(text_folder: Path) -> None:
    names = text_folder / "wrong.toml"
    names.write_text("[names]\n'T' = \"kinetc()\"\n", encoding="utf-8")
    options = ("--against", str(text_folder / "slider_crank.py"), "--names", str(names))
    message = refusal("audit", str(text_folder / "crank.tex"), *options)
    assert "wrong.toml" in message
    assert "kinetc" in message


def test_options_that_do_not_fit_are_refused(text_folder: Path) -> None:
    assert "--against" in refusal("audit", str(text_folder / "crank.tex"))
    assert "--against" in refusal("audit wang2017 --against", str(text_folder / "slider_crank.py"))
    assert "nothing.tex" in refusal(
        "audit nothing.tex --against", str(text_folder / "slider_crank.py")
    )


def test_notebook_rows_have_lines_of_the_file(text_folder: Path) -> None:
    cells = [
        {
            "cell_type": "markdown",
            "metadata": {},
            "source": ["The slider is at\n", "$$s = r\\cos\\phi + l\\cos\\beta$$\n"],
        },
        {
            "cell_type": "code",
            "metadata": {},
            "source": ["a = '$$s = r$$'"],
            "outputs": [],
            "execution_count": None,
        },
    ]
    notebook = text_folder / "crank.ipynb"
    notebook.write_text(
        json.dumps({"cells": cells, "metadata": {}, "nbformat": 4, "nbformat_minor": 5}, indent=1),
        "utf-8",
    )
    (row,) = answer(f"audit {notebook} --against", str(text_folder / "slider_crank.py"))["rows"]
    lines = notebook.read_text(encoding="utf-8").splitlines()
    assert "$$s = r" in lines[row["line"] - 1]
    assert row["status"] == "read"


def test_benchmark_fits_its_schema_and_writes_claims(tmp_path: Path) -> None:
    write_text(tmp_path / "crank", "text.tex", "3" * 64)
    result = answer(f"audit {tmp_path} --benchmark --slips 18 --out", str(tmp_path / "out"))
    jsonschema.validate(result, load_schema("audit benchmark"))
    score, by_units = (result["checkers"][name]["all"] for name in ("planter", "units"))
    assert score["detected"] == score["slips"] > by_units["detected"] > 0
    assert (score["errata"], score["errata_found"], score["false_alarms"]) == (1, 1, 0)
    lines = (tmp_path / "out" / "claims.jsonl").read_text(encoding="utf-8").splitlines()
    assert len(lines) == score["slips"] + score["errata"] + score["sound"]
    assert set(json.loads(lines[0])) == {"key", "latex", "text"}


def test_folder_that_is_no_corpus_is_refused(tmp_path: Path) -> None:
    assert "no such folder" in refusal("audit", str(tmp_path / "none"), "--benchmark")
    assert "source.toml" in refusal(f"audit {tmp_path} --benchmark")
    assert "--names" in refusal(f"audit {tmp_path} --benchmark --names names.toml")
    sentence = refusal("audit wang2017 --answers other.jsonl")
    assert "--answers" in sentence
    assert "--benchmark" in sentence
