"""Every tampered proof is refused, by planter and without it; what is not tampered with is
valid.
"""

from __future__ import annotations

from copy import deepcopy
from itertools import islice
from typing import Any

import numpy as np
import pytest

from planter.engine.proof import check_proof, objective
from planter.engine.proof.certificate_file import check_document, compute_digest
from planter.engine.proof.programs import record_program
from tests.planter.engine.proof.tampering import list_tampered, renew
from tests.planter.engine.proof.test_certificate_file import KINDS, check_apart, prove_document

Document = dict[str, Any]
FEWEST_KINDS = 60


@pytest.fixture(autouse=True)
def coarse(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(objective, "PANELS", 60)
    monkeypatch.setattr(objective, "PANELS_AT_POINT", 600)


@pytest.mark.parametrize(
    ("kind", "step"), [("sampled", 1), ("true", 6), pytest.param("true", 1, marks=pytest.mark.long)]
)
def test_every_tampered_proof_is_refused_by_both(kind: str, step: int) -> None:
    """Of a true one, whose check takes longer, the suite tampers with each sixth part."""
    document = prove_document(kind)
    assert check_document(document).valid
    assert check_apart(document) is None
    valid, count = [], 0
    for name, tampered in islice(list_tampered(document), 0, None, step):
        count += 1
        ours, reason = check_document(tampered), check_apart(tampered)
        valid += [f"{name}: planter"] if ours.valid else []
        valid += [f"{name}: check_proof"] if reason is None else []
        assert ours.valid or ours.reason, name
    assert not valid
    assert count >= FEWEST_KINDS // step


@pytest.mark.parametrize("kind", KINDS)
def test_statement_names_all_of_which_something_is_claimed(kind: str) -> None:
    document = prove_document(kind)
    statement = document["statement"]
    assert all(name in statement for name in (*document["parameters"], *document["quantities"]))
    assert check_document(document).statement == statement


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
