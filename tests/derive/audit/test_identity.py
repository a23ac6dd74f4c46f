"""Print, corrections and missing terms are the derivation: of every committed record, and of no
tampered one.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from copy import deepcopy
from functools import cache
from typing import Any

import pytest
import sympy as sp

from derive.audit.judge import FAULTS
from derive.evaluate import Point
from planter.kernels import generated
from tests.support.identity import find_identity_failure
from tests.support.mutations import CASES
from tests.support.replay import UnreadableEditError, list_corrected

Record = dict[str, Any]
RECORDS: list[Record] = generated.sidecar("audit")["equations"]
SEEDS = (101, 202, 303, 404)
"""Seeds of points at which no equation was judged."""
COMPARED = [
    r
    for r in RECORDS
    if r["verdict"] in (*FAULTS, "confirmed", "confirmed as rebuilt") and r["derived"]
]


@cache
def points(paper: str) -> tuple[Point, ...]:
    return tuple(Point(CASES[paper].subject.admissible(random.Random(seed))) for seed in SEEDS)


def find_failure(record: Record) -> str:
    return find_identity_failure(record, CASES[record["paper"]], points(record["paper"]))


def name(record: Record) -> str:
    return f"{record['paper']} {record['equation']}"


def find_record(paper: str, number: str) -> Record:
    return deepcopy(next(r for r in RECORDS if (r["paper"], r["equation"]) == (paper, number)))


@pytest.mark.parametrize("record", COMPARED, ids=name)
def test_every_finding_accounts_for_the_difference(record: Record) -> None:
    assert find_failure(record) == ""


def test_most_records_are_compared() -> None:
    assert {r["paper"] for r in COMPARED} == set(CASES)
    assert len(COMPARED) > len(RECORDS) / 2


@pytest.mark.parametrize(
    "record", [r for r in COMPARED if r["terms"] or r["unexplained"]], ids=name
)
def test_records_with_other_terms_fail(record: Record) -> None:
    for key in ("terms", "unexplained"):
        for place in range(len(record[key])):
            without, doubled, turned = (deepcopy(record) for _ in range(3))
            del without[key][place]
            doubled[key].append(doubled[key][place])
            turned[key][place]["term"] = f"-({turned[key][place]['term']})"
            for tampered in (without, doubled, turned):
                assert is_failure(tampered), (name(record), key, place)


def is_failure(record: Record) -> bool:
    """Return whether a record fails; one of a condition without terms has none to account for."""
    return bool(find_failure(record)) or record["derived"].split()[-2] != "="


def test_printed_moment_counted_as_missing_fails() -> None:
    """(20) prints -M_T of (23): -M_Az alone is not what it lacks."""
    record = find_record("wang2017", "20")
    absorbed = next(term for term in record["terms"] if "M_Az" in term["term"])
    absorbed["term"] = "-M_Az"
    assert "terms" in find_failure(record)
    record["unexplained"] = [{"term": "-F_Ex*y_E"}]
    assert find_failure(record) == ""


def forget_correction(record: Record) -> None:
    record["correction"] = []


def forget_change(record: Record) -> None:
    record["edited"] = record["printed"]


def swap_sides(record: Record) -> None:
    record["derived"] = record["printed"]


TAMPERED = (forget_correction, forget_change, swap_sides)
CORRECTED = [
    r
    for r in COMPARED
    if r["verdict"] == "misprint" and not r["correction"][0].startswith(("<", ">"))
]


@pytest.mark.parametrize("tamper", TAMPERED)
@pytest.mark.parametrize("record", CORRECTED, ids=name)
def test_records_with_other_corrections_fail(
    record: Record, tamper: Callable[[Record], None]
) -> None:
    tampered = deepcopy(record)
    tamper(tampered)
    assert find_failure(tampered)


@pytest.mark.parametrize("record", CORRECTED, ids=name)
def test_misprints_that_are_called_confirmed_fail(record: Record) -> None:
    tampered = deepcopy(record) | {"verdict": "confirmed", "correction": [], "edited": ""}
    assert find_failure(tampered)


@pytest.mark.long
def test_moment_balance_of_the_planet_lacks_a_small_share() -> None:
    """One sign, and moments of inertia and weight of both halves: at most 0.121 N m, 3.6 % of the
    tooth moment.
    """
    record, reference = find_record("wang2017", "20"), CASES["wang2017"].subject.reference(360)
    assert record["correction"] == ["sign of x_A*(F_Aoy + F_Ay)"]
    names = {str(symbol): symbol for symbol in reference[0]}
    lacking = sp.Add(*(sp.sympify(term["term"], locals=names) for term in record["terms"]))
    values = [Point(values) for values in reference]
    largest = max(abs(point(lacking)) for point in values)
    tooth = max(abs(point(names["M_Q"])) for point in values)
    assert float(largest) == pytest.approx(0.12116, abs=1e-5)
    assert float(largest / tooth) == pytest.approx(0.0358, abs=1e-4)
    assert record["difference"]["max_abs"] == pytest.approx(float(largest), rel=0.01)
    assert record["difference"]["share_of_largest"] < 0.037


def test_hinge_moment_is_what_the_terms_say() -> None:
    """The moment of the inner half about A without that of the cam force is that of its weight and
    inertia alone.
    """
    values = [Point(values) for values in CASES["wang2017"].subject.reference(24)]
    names = {str(symbol): symbol for symbol in values[0].values()}
    both = names["M_Az"] - names["F_Ex"] * names["y_E"], names["M_Aoz"]
    assert all(abs(point(both[0]) - point(both[1])) < 1e-20 for point in values), (
        "halves are mirror images"
    )


@pytest.mark.parametrize(
    ("sentence", "corrected"),
    [
        ("b for a", "b + cos(b)*a"),
        ("b for a throughout", "b + cos(b)*b"),
        ("a and b exchanged", "b + cos(a)*b"),
        ("sign of a*cos(b)", "a - a*cos(b)"),
        ("factor 1/2 on the whole", "a/2 + a*cos(b)/2"),
        ("factor 2 on the argument of cos(b)", "a + a*cos(2*b)"),
        ("sin for cos of b", "a + a*sin(b)"),
        ("without cos of b", "a + a*b"),
        ("without a*cos(b)", "a"),
        ("atan of a", "atan(a) + a*cos(b)"),
    ],
)
def test_sentences_of_corrections_are_carried_out(sentence: str, corrected: str) -> None:
    expr = sp.sympify("a + a*cos(b)")
    assert sp.sympify(corrected) in set(list_corrected(expr, [sentence], sp.sympify))


def test_unknown_sentence_is_an_error() -> None:
    with pytest.raises(UnreadableEditError, match="turned"):
        list(list_corrected(sp.Symbol("a"), ["turned upside down"], sp.sympify))
