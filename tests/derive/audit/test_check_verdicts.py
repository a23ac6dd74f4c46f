"""The program that repeats verdicts without derive: it accepts all committed ones, and refuses each
kind of tampered one.
"""

from __future__ import annotations

import ast
import io
import json
import subprocess
import sys
import tokenize
from collections.abc import Callable
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest

from derive.audit import check_verdicts
from derive.generated_folder import GENERATED

Record = dict[str, Any]
CHECKER = Path(check_verdicts.__file__)
FILE = GENERATED / "verdicts.json"
DOCUMENT: Record = json.loads(FILE.read_text(encoding="utf-8"))
RECORDS: list[Record] = DOCUMENT["records"]
MOST_LINES = 300
"""Lines of code that a referee reads."""


def name(record: Record) -> str:
    return f"{record['paper']} {record['equation']}"


def find_record(paper: str, number: str) -> Record:
    return deepcopy(next(r for r in RECORDS if (r["paper"], r["equation"]) == (paper, number)))


def find_reading(record: Record) -> Record:
    reading: Record = record["readings"][record["taken"]]
    return reading


def is_refused(record: Record) -> bool:
    """Return whether a record is refused, although its statement says what it states."""
    record["statement"] = check_verdicts.describe_verdict(record)
    try:
        check_verdicts.check_record(record, DOCUMENT["definitions"])
    except check_verdicts.FAILURES:
        return True
    return False


def run_checker(*arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-I", str(CHECKER), *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)


def test_every_committed_verdict_is_repeated() -> None:
    result = run_checker(str(FILE))
    assert result.returncode == 0, result.stdout
    assert result.stdout.splitlines()[-1] == "valid"
    assert "exactly" in result.stdout
    assert len(RECORDS) == len(json.loads((GENERATED / "audit.json").read_text())["equations"])


def test_checker_shares_no_code_and_is_short() -> None:
    source = CHECKER.read_text(encoding="utf-8")
    nodes = list(ast.walk(ast.parse(source)))
    modules = {alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names}
    modules |= {str(node.module) for node in nodes if isinstance(node, ast.ImportFrom)}
    assert {m.partition(".")[0] for m in modules} - sys.stdlib_module_names == {"flint"}
    docstrings = {
        line
        for node in nodes
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        for line in range(node.lineno, (node.end_lineno or 0) + 1)
    }
    silent = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT}
    silent.add(tokenize.ENDMARKER)
    tokens = tokenize.generate_tokens(io.StringIO(source).readline)
    code = {
        line
        for token in tokens
        if token.type not in silent
        for line in range(token.start[0], token.end[0] + 1)
    }
    assert len(code - docstrings) <= MOST_LINES


def test_unreadable_file_exits_with_two(tmp_path: Path) -> None:
    (tmp_path / "verdicts.json").write_text("{}", encoding="utf-8")
    assert run_checker(str(tmp_path / "verdicts.json")).returncode == 2
    assert run_checker(str(tmp_path / "absent.json")).returncode == 2


def test_tampered_file_exits_with_one(tmp_path: Path) -> None:
    tampered = deepcopy(DOCUMENT)
    tampered["records"][0]["statement"] = "it is wrong"
    (tmp_path / "verdicts.json").write_text(json.dumps(tampered), encoding="utf-8")
    result = run_checker(str(tmp_path / "verdicts.json"))
    assert result.returncode == 1
    assert "statement" in result.stdout


COMPARED = [r for r in RECORDS if r["legibility"] != "lost" and find_reading(r)["derived"]]
WITH_TERMS = [r for r in COMPARED if find_reading(r)["missing"] or find_reading(r)["unexplained"]]
FAULTS = [r for r in COMPARED if r["verdict"] in ("misprint", "incomplete", "contradicted")]


@pytest.mark.parametrize("record", WITH_TERMS, ids=name)
def test_other_terms_are_refused(record: Record) -> None:
    if find_reading(record)["relations"][0] != "=":
        pytest.skip("a condition has no terms to account for")
    for part in ("missing", "unexplained"):
        for place, term in enumerate(find_reading(record)[part]):
            for terms in ([], [term, term], [f"-({term})"]):
                tampered = deepcopy(record)
                find_reading(tampered)[part][place : place + 1] = terms
                assert is_refused(tampered), (part, place, terms)


@pytest.mark.parametrize("record", FAULTS, ids=name)
def test_faults_of_a_sound_print_are_refused(record: Record) -> None:
    """A print that is its derivation has no witness against it."""
    tampered = deepcopy(record)
    reading = find_reading(tampered)
    reading["read"], reading["relations"][0] = reading["derived"], reading["relations"][2]
    assert is_refused(tampered)


@pytest.mark.parametrize("record", FAULTS, ids=name)
def test_wrong_prints_are_not_confirmed(record: Record) -> None:
    tampered = deepcopy(record)
    tampered["verdict"] = find_reading(tampered)["verdict"] = "confirmed"
    assert is_refused(tampered)
    nothing: Record = {"steps": [], "missing": [], "unexplained": [], "loose": {}}
    find_reading(tampered).update(nothing)
    assert is_refused(tampered)


@pytest.mark.parametrize("record", COMPARED, ids=name)
def test_other_transcriptions_are_refused(record: Record) -> None:
    tampered = deepcopy(record)
    if find_reading(record)["text"]:
        find_reading(tampered)["text"] += " + 1"
    else:
        tampered["transcription"] += " + 1"
    assert is_refused(tampered)


def count_printed_moment_as_missing(record: Record) -> None:
    """(20) prints -M_T of (23), which is part of the hinge moment M_Az."""
    reading = find_reading(record)
    place = next(i for i, term in enumerate(reading["missing"]) if "F_Ex" in term)
    reading["missing"][place] = "-M_Az"
    reading["unexplained"] = ["-F_Ex*y_E"]
    record["verdict"] = reading["verdict"] = "contradicted"


def strike_printed_moment(record: Record) -> None:
    """The same, with the printed moment taken away by a correction."""
    reading = find_reading(record)
    place = next(i for i, term in enumerate(reading["missing"]) if "F_Ex" in term)
    reading["missing"][place] = "-M_Az"
    (steps,) = reading["steps"]
    side = steps[-1]["after"]
    step = {"words": "without -F_Ex*y_E", "old": "-F_Ex*y_E", "new": "0", "swaps": {}}
    steps.append(step | {"frame": f"{side} + F_Ex*y_E + _place", "after": f"{side} + F_Ex*y_E"})


def replace_all_by_the_derivation(record: Record) -> None:
    reading = find_reading(record)
    step = {
        "words": "as derived",
        "old": reading["initial"],
        "new": reading["derived"],
        "swaps": {},
    }
    reading["steps"] = [[step | {"frame": "_place", "after": reading["derived"]}]]
    reading["missing"] = []
    record["verdict"] = reading["verdict"] = "misprint"


def correct_something_else(record: Record) -> None:
    find_reading(record)["steps"][0][0]["after"] += " + 1"


def forget_correction(record: Record) -> None:
    find_reading(record)["steps"] = []


def multiply_by_zero(record: Record) -> None:
    find_reading(record)["multiple"] = "0"


def start_from_zero(record: Record) -> None:
    find_reading(record)["undivided"] = "0"


def draw_one_point(record: Record) -> None:
    reading = find_reading(record)
    reading["ranges"] = {symbol: ["1", "1"] for symbol in reading["ranges"]}


def forget_relation(record: Record) -> None:
    reading = find_reading(record)
    reading["flips"], reading["relations"][1] = False, reading["relations"][0]


def turn_relation(record: Record) -> None:
    record["transcription"] = record["transcription"].replace("<=", ">=")
    find_reading(record)["relations"][0] = ">="


def change_printed_value(record: Record) -> None:
    record["values"][0]["values"]["f_1"] = "148.03"


def call_legible_print_lost(record: Record) -> None:
    record["verdict"] = find_reading(record)["verdict"] = "reconstructed"


def move_point_of_use(record: Record) -> None:
    find_reading(record)["points"][0]["x_S"] = "-1"


def take_another_reading(record: Record) -> None:
    record["taken"] = 1 - record["taken"]


def let_support_be_at_rest(record: Record) -> None:
    reading = next(reading for reading in record["readings"] if reading["loose"])
    reading["loose"] = dict.fromkeys(reading["loose"], "0")


def move_witness_to_agreement(record: Record) -> None:
    values = find_reading(record)["witness"]["values"]
    values["r"], values["rho_t"] = "1", "2"
    values["a1"] = "0.001"


TAMPERED: list[tuple[str, str, Callable[[Record], None]]] = [
    ("wang2017", "20", count_printed_moment_as_missing),
    ("wang2017", "20", strike_printed_moment),
    ("wang2017", "24", replace_all_by_the_derivation),
    ("wang2017", "5", correct_something_else),
    ("wang2017", "5", forget_correction),
    ("wang2017", "12", multiply_by_zero),
    ("wang2017", "12", start_from_zero),
    ("wang2017", "1", draw_one_point),
    ("shi2021", "5b", forget_relation),
    ("shi2021", "5d", turn_relation),
    ("wang2017", "29", change_printed_value),
    ("wang2017", "12", call_legible_print_lost),
    ("yu2023", "phi4, other quadrants", move_point_of_use),
    ("wang2017", "17", take_another_reading),
    ("shi2021", "9", let_support_be_at_rest),
    ("shi2021", "fillet", move_witness_to_agreement),
]


@pytest.mark.parametrize(("paper", "number", "tamper"), TAMPERED)
def test_each_rule_refuses_a_tampered_record(
    paper: str, number: str, tamper: Callable[[Record], None]
) -> None:
    record = find_record(paper, number)
    assert not is_refused(deepcopy(record))
    tamper(record)
    assert is_refused(record)


def test_angle_sums_are_equal_exactly() -> None:
    ring = check_verdicts.Ring("sin(a + 2*b)", "sin(a)", "cos(a)", "sin(b)", "cos(b)")
    text = "sin(a + 2*b) - sin(a)*(cos(b)**2 - sin(b)**2) - cos(a)*2*sin(b)*cos(b)"
    assert check_verdicts.evaluate_in(text, ring).above == 0
    assert check_verdicts.evaluate_in(f"{text} + sin(a)", ring).above != 0


def test_numbers_are_enclosed() -> None:
    value = check_verdicts.value_at("Piecewise((sqrt(x), x < 1), (1/x, True))", {"x": 2})
    assert value.contains(0.5)
    assert float(value.rad()) < 1e-15
    with pytest.raises(check_verdicts.UndecidedError):
        check_verdicts.value_at("sqrt(x)", {"x": -1})
