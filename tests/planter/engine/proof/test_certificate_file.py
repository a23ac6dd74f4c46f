"""Files of proofs, checked by planter and without it: valid ones, tampered ones, interrupted ones
that are resumed.
"""

from __future__ import annotations

import ast
import json
import sys
from collections.abc import Callable
from copy import deepcopy
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from planter.engine.proof import check_proof, objective
from planter.engine.proof.certificate_file import (
    build_document,
    check_document,
    compute_digest,
    format_document,
    read_document,
    write_certificate,
)
from planter.engine.proof.jets import ANYWHERE, Space
from planter.engine.proof.objective import BoundedMeasure, ProvableObjective
from planter.engine.proof.roots import enclose_roots
from planter.engine.proof.search import Incumbent, Proof
from planter.kernels import generated
from planter.task import AUTO
from tests.planter.engine.proof.tampering import renew
from tests.planter.engine.proof.test_panels import find_kinks, true_objective
from tests.planter.engine.proof.test_search import BENT, LOWER, OPTIMUM, SAMPLES, UPPER, value

Document = dict[str, Any]
KINDS = {"sampled": (SAMPLES, OPTIMUM), "true": (None, np.array([UPPER[0], LOWER[1], 0.0]))}
"""Samples and optimum; the true objective is symmetrical in the third parameter."""
LEAST_MEAN = 0.5
SOURCES = generated.hash_modules([generated.module("array.curve_ellipse")])
"""Hashes of some generated code; the programs of these tests are from none."""


def build(kind: str, limits: tuple[BoundedMeasure, ...] = ()) -> ProvableObjective:
    terms = [BoundedMeasure("range", 0, weight=0.6), BoundedMeasure("variance", 0, weight=0.4)]
    return ProvableObjective(BENT, terms, limits, KINDS[kind][0], find_kinks=find_kinks)


def prove(
    kind: str,
    seconds: float = 60.0,
    limits: tuple[BoundedMeasure, ...] = (),
    earlier: Path | None = None,
) -> tuple[Proof, str]:
    samples, optimum = KINDS[kind]
    bounds = build(kind)(optimum, optimum)
    incumbent = Incumbent(optimum, {}, (bounds.lower_bound + bounds.reached) / 2, samples)
    return write_certificate(
        lambda: build(kind, limits),
        (LOWER, UPPER),
        incumbent,
        ("a", "b", "c"),
        SOURCES,
        seconds,
        None,
        AUTO,
        earlier,
    )


@pytest.fixture(autouse=True)
def coarse(monkeypatch: pytest.MonkeyPatch) -> None:
    """Few panels: enough for a response without steep parts."""
    monkeypatch.setattr(objective, "PANELS", 60)
    monkeypatch.setattr(objective, "PANELS_AT_POINT", 600)


@cache
def prove_document(kind: str) -> Document:
    document: Document = json.loads(prove(kind)[1])
    return document


def check_apart(document: Document) -> str | None:
    """Return why the checker that is independent of planter refuses a document, None if it does
    not.
    """
    try:
        check_proof.check_size(document)
        check_proof.PROOF = check_proof.ProofClaims(document)
        check_proof.check_claims(document, lambda jobs: map(check_proof.check_box, jobs))
    except Exception as error:  # of whatever kind: the file may hold anything
        return str(error)
    return None


def test_checker_imports_nothing_of_planter() -> None:
    tree = ast.parse(Path(check_proof.__file__).read_text(encoding="utf-8"))
    imports = [node for node in ast.walk(tree) if isinstance(node, ast.Import | ast.ImportFrom)]
    names = {alias.name for node in imports if isinstance(node, ast.Import) for alias in node.names}
    names |= {str(node.module) for node in imports if isinstance(node, ast.ImportFrom)}
    assert {name.partition(".")[0] for name in names} - sys.stdlib_module_names == {"flint"}


@pytest.mark.parametrize("kind", KINDS)
def test_proofs_of_a_known_optimum_are_valid(kind: str) -> None:
    document, optimum = prove_document(kind), KINDS[kind][1]
    result = check_document(document)
    objective_there = value(optimum) if kind == "sampled" else true_objective(optimum)
    assert result.valid, result.reason
    assert result.lower_bound is not None
    assert result.incumbent is not None
    assert result.lower_bound <= objective_there <= result.incumbent
    assert result.gap == result.incumbent - result.lower_bound <= 1e-6 * objective_there
    assert (result.kind, result.boxes) == (
        kind,
        sum("evidence" in node for node in document["nodes"]),
    )
    assert result.objective == pytest.approx(objective_there, rel=1e-7)
    assert check_apart(document) is None


def test_weaker_claims_are_valid() -> None:
    document = deepcopy(prove_document("sampled"))
    weaken(find_node(document, "bound"), "bound", -1.0)
    weaken(document["incumbent"], "upper_bound", 1e-3)
    renew(document)
    assert not check_document(document).valid, "a box is bounded by less than what is stated of all"
    assert check_apart(document)
    weaken(document, "lower_bound", -1.0)
    renew(document)
    assert check_document(document).valid
    assert check_apart(document) is None


def weaken(entry: Document, key: str, change: float) -> None:
    entry[key] = (float.fromhex(entry[key]) + change).hex()


def find_node(document: Document, key: str) -> Document:
    """Return the last node with a key, for a bound one without children."""
    return next(
        node
        for node in reversed(document["nodes"])
        if key in node and (key != "bound" or "children" not in node)
    )


def find_operation(document: Document, *names: str) -> list[Any]:
    operations = [step for stage in document["response"]["stages"] for step in stage["operations"]]
    operation: list[Any] = next(step for step in operations if step[0] in names)
    return operation


def raise_bound(document: Document) -> None:
    weaken(find_node(document, "bound"), "bound", 1e-4)
    weaken(document, "lower_bound", 1e-4)
    weaken(document["incumbent"], "upper_bound", 1e-4)


def leave_out_box(document: Document) -> None:
    find_node(document, "split")["children"].pop()


def share_box(document: Document) -> None:
    node = find_node(document, "split")
    node["children"][1] = node["children"][0]


def flip_side(document: Document) -> None:
    side = find_node(document, "sides")["sides"][0]
    side[1] = {"lower": "upper", "upper": "lower"}[side[1]]


def move_split(document: Document) -> None:
    node = next(node for node in document["nodes"] if "split" in node)
    k = node["split"][0]
    node["split"][1] = (LOWER[k] + 0.9 * (UPPER[k] - LOWER[k])).hex()


def split_outside(document: Document) -> None:
    node = next(node for node in document["nodes"] if "split" in node)
    node["split"][1] = (UPPER[node["split"][0]] + 0.1).hex()


def change_constant(document: Document) -> None:
    operation = next(
        step
        for stage in document["response"]["stages"]
        for step in stage["operations"]
        if step[0] == "constant" and float.fromhex(step[2][0]) not in (0.0, 1.0)
    )
    operation[2][0] = (1.01 * float.fromhex(operation[2][0])).hex()


def change_program(document: Document) -> None:
    operation = find_operation(document, "sin", "cos")
    operation[0] = {"sin": "cos", "cos": "sin"}[operation[0]]


def leave_out_half(document: Document) -> None:
    document["response"]["offsets"].pop()


def raise_lower_bound(document: Document) -> None:
    weaken(document, "lower_bound", 1e-4)


def lower_incumbent(document: Document) -> None:
    weaken(document["incumbent"], "upper_bound", -1e-4)


def move_incumbent(document: Document) -> None:
    document["incumbent"]["x"][0] = (UPPER[0] + 0.1).hex()


def remove_evidence(document: Document) -> None:
    del find_node(document, "bound")["evidence"]


def change_weight(document: Document) -> None:
    document["terms"][0]["weight"] = (0.59).hex()


def change_measure(document: Document) -> None:
    document["terms"][1]["measure"] = "rms"


def widen_box(document: Document) -> None:
    document["box"][1][0] = (0.8).hex()


def change_kind(document: Document) -> None:
    document["kind"] = {"true": "sampled", "sampled": "true"}[document["kind"]]


def spoil_program(document: Document) -> None:
    find_operation(document, "multiply")[1][0] = 10_000


TAMPERED = (
    raise_bound,
    leave_out_box,
    share_box,
    flip_side,
    move_split,
    split_outside,
    change_constant,
    change_program,
    leave_out_half,
    raise_lower_bound,
    lower_incumbent,
    move_incumbent,
    remove_evidence,
    change_weight,
    change_measure,
    widen_box,
    change_kind,
    spoil_program,
)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("tamper", TAMPERED)
def test_tampered_proofs_are_refused(kind: str, tamper: Callable[[Document], None]) -> None:
    """Also if their hash is computed again, by planter and without it."""
    document = deepcopy(prove_document(kind))
    tamper(document)
    for check in (lambda: check_document(document).reason, lambda: check_apart(document)):
        reason = check()
        assert reason is not None
        assert "sha256" in reason
    result = check_document(renew(document))
    assert not result.valid
    assert result.lower_bound is None
    assert result.reason
    assert check_apart(document)


def test_proofs_of_other_generated_code_are_refused() -> None:
    document = deepcopy(prove_document("sampled"))
    assert check_document(document).valid
    document["generated"]["array.curve_ellipse"] = 64 * "0"
    document["sha256"] = compute_digest(document)
    reason = check_document(document).reason
    assert reason is not None
    assert "array.curve_ellipse" in reason


@pytest.mark.parametrize(("kind", "sign"), [("sampled", 1), ("sampled", -1), ("true", 1)])
def test_proofs_under_a_limit_are_valid(kind: str, sign: int) -> None:
    """The mean is 4 x0 / pi, greatest at the optimum, which is excluded if it may not be as
    great.
    """
    limits = (BoundedMeasure("mean", 0, sign=sign, limit=4 * LEAST_MEAN / np.pi),)
    proof, text = prove(kind, 5.0, limits)
    document = json.loads(text)
    result = check_document(document)
    assert result.valid, result.reason
    assert check_apart(document) is None
    assert (result.incumbent is None) == (sign > 0)
    assert proof.result.proved
    document["limits"][0]["sign"] = -sign
    renew(document)
    assert not check_document(document).valid
    assert check_apart(document)


def test_interrupted_proof_is_resumed(tmp_path: Path) -> None:
    path, (begun, text) = tmp_path / "proof.json", prove("true", 0.0)
    path.write_text(text)
    assert not begun.result.proved
    assert check_document(read_document(path)).valid, "what it states so far holds"
    middle, text = prove("true", 0.2, earlier=path)
    assert middle.root.bound == begun.root.bound
    path.write_text(text)
    end, text = prove("true", earlier=path)
    afresh, _ = prove("true")
    assert end.result.proved
    assert check_document(json.loads(text)).valid
    assert len(list(end.root.list_nodes())) == len(list(afresh.root.list_nodes()))


def test_earlier_proof_of_another_objective_is_not_resumed(tmp_path: Path) -> None:
    path = tmp_path / "proof.json"
    document = deepcopy(prove_document("true"))
    raise_bound(document)
    path.write_text(format_document(document))
    spoiled, _ = prove("true", 0.0, earlier=path)
    path.write_text(prove("sampled")[1])
    other, _ = prove("true", 0.0, earlier=path)
    assert not spoiled.result.proved
    assert not other.result.proved


def test_document_is_the_same_when_it_is_written_again() -> None:
    proof, text = prove("true")
    assert json.loads(
        format_document(build_document(proof, build("true"), ("a", "b", "c"), SOURCES))
    ) == json.loads(text)


def test_checker_encloses_a_root_that_is_exactly_zero() -> None:
    space = check_proof.BoxSpace([0.0], [1.0], 0)
    unit, zero = space.constant(1), space.constant(0)
    (root,) = check_proof.enclose_roots(
        space, 1, [0.0], lambda unknowns: ([unknowns[0] * unit - zero], [[unit]])
    )
    assert root.v.contains(0)
    assert root.v.rad() < 1e-200


@pytest.mark.parametrize("half", [0.001, 0.02, 0.05])
@pytest.mark.parametrize("place", [0.0, 0.4, 1.0])
def test_both_checkers_enclose_the_roots_of_coupled_equations(place: float, half: float) -> None:
    """(r cos b, r sin b) = (x, 1): at x = 0 the radius does not change to first order."""
    lower, upper = [place - half], [place + half]
    start = [float(np.hypot(place, 1)), float(np.arctan2(1, place))]

    def polar(
        cos: Any, sin: Any, radius: Any, x: Any, unit: Any
    ) -> tuple[list[Any], list[list[Any]]]:
        return [radius * cos - x, radius * sin - unit], [[cos, -radius * sin], [sin, radius * cos]]

    space = Space(np.array(lower), np.array(upper))
    roots = enclose_roots(
        space,
        np.array(start)[:, None],
        lambda a: polar(
            a[1].call("cos"), a[1].call("sin"), a[0], space.parameters()[0], space.lift(1)
        ),
    )
    balls = check_proof.BoxSpace(lower, upper, 0)
    checked = check_proof.enclose_roots(
        balls,
        2,
        start,
        lambda a: polar(
            a[1].call("cos"), a[1].call("sin"), a[0], balls.parameters()[0], balls.constant(1)
        ),
    )
    x = np.linspace(place - half, place + half, 9)
    for root, ball, exact in zip(roots, checked, (np.hypot(x, 1), np.arctan2(1, x)), strict=True):
        value = root.value[ANYWHERE]
        assert ((value.low <= exact) & (exact <= value.high)).all()
        assert float(ball.v.lower()) <= exact.min() <= exact.max() <= float(ball.v.upper())
        assert value.rad.max() < 2 * np.ptp(exact) + half**2
