"""Blocks of a page on the proof of an optimum."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from planter.report import labels
from planter.report.html import Block, Keys, Table, Text


def describe_proof(proof: Mapping[str, Any]) -> Iterator[Block]:
    """Yield the bound on the objective of any design within the bounds, its gap to the optimum, and the method.

    Bound and gap are dashes if the objective is not bounded.
    """
    yield Text(f"{proof['statement'][0].upper()}{proof['statement'][1:]}.", "" if proof["proved"] else "warning")
    yield Keys({labels.format_label(key): value for key, value in proof.items() if key not in ("statement", "design")})
    rows = [(labels.format_label(key), value) for key, value in proof["design"].items()]
    yield Table(("quantity", "best design that is known"), rows)
    yield Text(
        "By branch and bound on enclosures of the objective and its derivatives over boxes, in doubles whose rounding "
        "is added to each: it rests on the arithmetic of IEEE 754, and on sines, cosines, arc tangents within 2^-49.",
        "note",
    )
