"""Files of proofs with any part exchanged are checked or refused, in valid JSON and in bounded
time.
"""

from __future__ import annotations

import json
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, seed
from hypothesis import strategies as st

from planter.engine.proof.certificate_file import check_document, compute_digest, format_document
from tests.attack.test_attack import SEED, share
from tests.planter.engine.proof.test_certificates import Document, check_apart, prove_document
from tests.support.cli import run

HEX = ("inf", "-inf", "nan", "0x1.0p+2000", (1e300).hex(), "0x0p+0", "x", "")
OTHER = (None, True, [], {}, 10**6, 10**30, -1, 0, 0.5, "1/0", "1e999999999", "9" * 50, *HEX)


def list_places(entry: Any, *path: str | int) -> list[tuple[str | int, ...]]:
    """Return the paths of all parts of a document, but of long lists only the first and the
    last.
    """
    if isinstance(entry, dict):
        return [path, *(place for key in entry for place in list_places(entry[key], *path, key))]
    if isinstance(entry, list):
        ends = sorted({0, 1, len(entry) - 1} & set(range(len(entry))))
        return [path, *(place for k in ends for place in list_places(entry[k], *path, k))]
    return [path]


def exchange(document: Document, place: tuple[str | int, ...], content: object) -> Document:
    """Return a document with another content at a place, and with the hash of it."""
    changed = deepcopy(document)
    entry: Any = changed
    for key in place[:-1]:
        entry = entry[key]
    entry[place[-1]] = content
    changed["sha256"] = compute_digest(changed)
    return changed


@seed(SEED)
@share
@given(
    kind=st.sampled_from(["true", "sampled"]),
    share_of_places=st.floats(0, 1),
    content=st.sampled_from(OTHER),
)
def test_exchanged_parts_end_in_a_result(
    kind: str, share_of_places: float, content: object
) -> None:
    document = prove_document(kind)
    places = [place for place in list_places(document) if place and place != ("sha256",)]
    place = places[int(share_of_places * (len(places) - 1))]
    result = check_document(exchange(document, place, content))
    text = json.dumps(result.table(), allow_nan=False)
    assert json.loads(text)["valid"] is (result.reason is None)


@pytest.mark.parametrize("number", ["inf", "-inf", "nan"])
@pytest.mark.parametrize(
    "place",
    [
        ("lower_bound",),
        ("incumbent", "upper_bound"),
        ("incumbent", "x", 0),
        ("box", 0, 1),
        ("terms", 0, "weight"),
        ("nodes", 0, "bound"),
    ],
)
def test_numbers_that_are_not_finite_are_refused(
    place: tuple[str | int, ...], number: str, tmp_path: Path
) -> None:
    document = exchange(prove_document("sampled"), place, number)
    if (place[-1], number) == ("bound", "-inf"):  # claims nothing
        return
    assert not check_document(document).valid
    assert check_apart(document)
    path = tmp_path / "proof.json"
    path.write_text(format_document(document))
    code, out, _ = run(f"prove --check {path} --json")
    assert code == 1
    assert json.loads(out, parse_constant=pytest.fail)["valid"] is False


LARGE = {
    "samples": (("samples",), 10**6),
    "power": (("response", "stages", 0, "operations", 0), ["power", [0], [(1e9).hex()]]),
    "digits of a period": (("response", "period"), "1/" + "3" * 50),
    "exponent of a period": (("response", "period"), "1e99999999"),
}


@pytest.mark.parametrize("case", LARGE)
def test_proof_that_asks_for_too_much_is_refused(case: str, tmp_path: Path) -> None:
    document = exchange(prove_document("sampled"), *LARGE[case])
    result = check_document(document)
    assert not result.valid
    assert check_apart(document)
    path = tmp_path / "proof.json"
    path.write_text(format_document(document))
    assert run(f"prove --check {path} --json")[0] == 1


def test_too_many_panels_are_refused() -> None:
    document = deepcopy(prove_document("true"))
    assert check_document(document).valid
    node = next(node for node in document["nodes"] if "panels" in node.get("evidence", {}))
    node["evidence"]["panels"]["parts"][0] = 10**7
    document["sha256"] = compute_digest(document)
    assert "panels" in str(check_document(document).reason)
    assert "panels" in str(check_apart(document))
