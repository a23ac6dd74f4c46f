"""Files of proofs, checked by planter and without it: valid ones, tampered ones, interrupted ones
that are resumed.
"""

from __future__ import annotations

import ast
import json
import sys
from copy import deepcopy
from functools import cache
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from planter.engine.proof import check_proof, objective
from planter.engine.proof.certificate_file import (
    ProvedMachine,
    check_document,
    compute_digest,
    format_document,
    read_document,
    write_certificate,
)
from planter.engine.proof.objective import BoundedMeasure, ProvableObjective
from planter.engine.proof.programs import record_program
from planter.engine.proof.search import Incumbent, Proof
from planter.kernels import generated
from planter.task import AUTO
from tests.planter.engine.proof.tampering import list_tampered, renew
from tests.planter.engine.proof.test_panels import true_objective
from tests.planter.engine.proof.test_search import OPTIMUM
from tests.planter.engine.proof.toys import LOWER, SAMPLES, UPPER, build_bent, value

Document = dict[str, Any]
FEWEST_KINDS = 60
KINDS = {"sampled": (SAMPLES, OPTIMUM), "true": (None, np.array([UPPER[0], LOWER[1], 0.0]))}
"""Samples and optimum; the true objective is symmetrical in the third parameter."""
LEAST_MEAN = 0.5
MACHINE = ProvedMachine(
    ("a", "b", "c"),
    (1.0, 1.0, 1.0),
    generated.hash_modules([generated.module("array.curve_ellipse")]),
    "bent curve",
    {},
)
"""The machine of these tests, with hashes of some generated code."""


def prove(
    kind: str,
    seconds: float = 60.0,
    limits: tuple[BoundedMeasure, ...] = (),
    earlier: Path | None = None,
) -> tuple[Proof, str]:
    samples, optimum = KINDS[kind]
    bounds = build_bent(samples)(optimum, optimum)
    incumbent = Incumbent(optimum, {}, (bounds.lower_bound + bounds.reached) / 2, samples)
    return write_certificate(
        lambda: build_bent(samples, limits),
        (LOWER, UPPER),
        incumbent,
        MACHINE,
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


def rebuild(_: Document) -> ProvableObjective:
    """Return the objective of the machine of these tests, as it is generated here."""
    return build_bent(None)


def check_apart(document: Document) -> str | None:
    """Return why the checker that is independent of planter refuses a document, None if it does
    not.
    """
    try:
        check_proof.check_form(document)
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
    names = *document["parameters"], *document["quantities"]
    assert all(name in str(result.statement) for name in names)


def test_weaker_claims_are_valid() -> None:
    document = deepcopy(prove_document("sampled"))
    leaves = [node for node in document["nodes"] if "bound" in node and "children" not in node]
    weaken(leaves[-1], "bound", -1.0)
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
    weaken(document, "lower_bound", 1e-4)
    path.write_text(format_document(document))
    spoiled, _ = prove("true", 0.0, earlier=path)
    path.write_text(prove("sampled")[1])
    other, _ = prove("true", 0.0, earlier=path)
    assert not spoiled.result.proved
    assert not other.result.proved


def test_checker_encloses_a_root_that_is_exactly_zero() -> None:
    space = check_proof.BoxSpace([0.0], [1.0], 0)
    unit, zero = space.constant(1), space.constant(0)
    (root,), _, _ = check_proof.enclose_roots(
        space, 1, [0.0], lambda unknowns: ([unknowns[0] * unit - zero], [[unit]])
    )
    assert root.v.contains(0)
    assert root.v.rad() < 1e-200


@pytest.mark.parametrize("half", [0.001, 0.02, 0.05])
@pytest.mark.parametrize("place", [0.0, 0.4, 1.0])
def test_checker_encloses_the_roots_of_coupled_equations(place: float, half: float) -> None:
    """(r cos b, r sin b) = (x, 1): at x = 0 the radius does not change to first order."""
    space = check_proof.BoxSpace([place - half], [place + half], 0)
    start = [float(np.hypot(place, 1)), float(np.arctan2(1, place))]

    def polar(q: list[Any]) -> tuple[list[Any], list[list[Any]]]:
        radius, (cos, sin) = q[0], (q[1].call(name) for name in ("cos", "sin"))
        gaps = [radius * cos - space.parameters()[0], radius * sin - space.constant(1)]
        return gaps, [[cos, -radius * sin], [sin, radius * cos]]

    x = np.linspace(place - half, place + half, 9)
    roots, _, _ = check_proof.enclose_roots(space, 2, start, polar)
    for ball, exact in zip(roots, (np.hypot(x, 1), np.arctan2(1, x)), strict=True):
        assert float(ball.v.lower()) <= exact.min() <= exact.max() <= float(ball.v.upper())
        assert float(ball.v.rad()) < 2 * np.ptp(exact) + half**2


@pytest.mark.parametrize(
    ("kind", "step"), [("sampled", 1), ("true", 6), pytest.param("true", 1, marks=pytest.mark.long)]
)
def test_every_tampered_proof_is_refused_by_both(kind: str, step: int) -> None:
    """Of a true one, whose check takes longer, the suite tampers with each sixth part."""
    valid, count = [], 0
    for name, tampered in islice(list_tampered(prove_document(kind)), 0, None, step):
        count += 1
        ours, reason = check_document(tampered, rebuild), check_apart(tampered)
        valid += [f"{name}: planter"] if ours.valid else []
        valid += [f"{name}: check_proof"] if reason is None else []
        assert ours.valid or ours.reason, name
    assert not valid
    assert count >= FEWEST_KINDS // step


def test_programs_of_another_machine_are_refused() -> None:
    document = prove_document("sampled")
    assert check_document(document, rebuild).compared == ["bent curve"]
    other = deepcopy(document)
    (*_, last) = other["response"]["stages"]
    number = {"operations": [["constant", [], [(0.5).hex()]]], "outputs": [0]}
    other["response"]["stages"] = [last | number]
    bound = (-1e-9).hex()
    other["nodes"], other["lower_bound"] = [{"bound": bound, "evidence": {}}], bound
    other["incumbent"] |= {"upper_bound": None}
    assert check_document(renew(other)).valid, "it is true of a force that is the same everywhere"
    assert check_apart(other) is None
    reason = check_document(other, rebuild).reason
    assert reason is not None
    assert "stages" in reason
    for key, content in (("continuous", False), ("period", "1"), ("offsets", ["0"])):
        other = deepcopy(document)
        other["response"][key] = content
        assert key in str(check_document(renew(other), rebuild).reason)


def test_continuous_choices_follow_from_the_form_of_a_program() -> None:
    def choose(xp: Any, x: Any, yes: Any, no: Any) -> Any:
        return xp.where(xp.lift(x).reaches(0), yes, no)

    codes = (
        (lambda xp, x: xp.absolute(x[0]), True),
        (lambda xp, x: xp.maximum(x[0], x[1]), True),
        (lambda xp, x: xp.minimum(x[0], 2.0), True),
        (lambda xp, x: choose(xp, x[0], x[0], -x[0]), True),
        (lambda xp, x: choose(xp, x[0], x[1], -x[1]), False),
        (lambda xp, x: choose(xp, x[0] - x[1], x[0], -x[1]), False),
        (lambda xp, x: choose(xp, x[0], 1.0, 2.0), False),
        (lambda xp, x: xp.absolute(x[0]) + choose(xp, x[0], x[1], 0.0), False),
    )
    for code, is_continuous in codes:
        program = record_program(lambda xp, x, code=code: [code(xp, x)], 2).to_document()
        steps = program["operations"]
        conditions = [n for n, step in enumerate(steps) if step[0] == "below"]
        assert conditions
        plain = json.loads(json.dumps(steps))
        assert all(check_proof.is_continuous_choice(plain, n) for n in conditions) is is_continuous


def test_exchanged_parameter_names_do_not_keep_the_statement() -> None:
    document = deepcopy(prove_document("sampled"))
    document["parameters"][:2] = document["parameters"][1::-1]
    document["sha256"] = compute_digest(document)
    assert not check_document(document).valid
    assert check_apart(document)


def test_widened_box_is_refused_in_words() -> None:
    document = deepcopy(prove_document("true"))
    document["box"][1][0] = (0.8).hex()
    reason = check_document(renew(document)).reason
    assert reason
    assert "Error" not in reason


FORMS = {
    "absolute value": (lambda xp, x: xp.absolute(x[0]), True),
    "scaled absolute value": (lambda xp, x: xp.absolute(x[0]) / 1000.0 * (2 * xp.pi), True),
    "square": (lambda xp, x: x[0] * x[0] + x[1] ** 2, True),
    "square root": (lambda xp, x: xp.sqrt(x[0]), True),
    "negative absolute value": (lambda xp, x: -xp.absolute(x[0]), False),
    "negative scale": (lambda xp, x: xp.absolute(x[0]) / -1000.0, False),
    "plain": (lambda xp, x: x[0], False),
    "negated": (lambda xp, x: -x[0], False),
    "cube": (lambda xp, x: x[0] ** 3, False),
    "another's absolute value": (
        lambda xp, x: xp.where(xp.lift(x[1]).reaches(0), x[0], -x[0]),
        False,
    ),
    "minimum": (lambda xp, x: xp.minimum(x[0], -x[0]), False),
    "reversed absolute value": (
        lambda xp, x: xp.where(xp.lift(x[0]).reaches(0), -x[0], x[0]),
        False,
    ),
    "sine": (lambda xp, x: xp.sin(x[0]), False),
}


@pytest.mark.parametrize("form", FORMS)
def test_sizes_follow_from_the_form_of_a_program(form: str) -> None:
    code, is_size = FORMS[form]
    program = record_program(lambda xp, x: [code(xp, x)], 2).to_document()
    (output,) = program["outputs"]
    assert check_proof.is_size(program["operations"], output) is is_size
    if is_size:
        values = np.linspace(-2, 2, 9)
        assert form == "square root" or all(
            code(np_namespace, [value, -value]) >= 0 for value in values
        )


class _NumberNamespace:
    pi = np.pi
    absolute = staticmethod(abs)


np_namespace = _NumberNamespace()
