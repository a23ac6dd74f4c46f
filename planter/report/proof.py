"""The proof of an optimum on a page."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from planter.report import labels
from planter.report.html import Block, Keys, Table, Text


def describe_proof(found: Mapping[str, Any]) -> Iterator[Block]:
    """Yield how much better than the optimum any design within the bounds can be at most, and what that rests on.

    Bound and gap are dashes if nothing bounds the objective.
    """
    yield Text(f"{found['statement'][0].upper()}{found['statement'][1:]}.", "" if found["proved"] else "warning")
    yield Keys({labels.label(key): value for key, value in found.items() if key not in ("statement", "design")})
    rows = [(labels.label(key), value) for key, value in found["design"].items()]
    yield Table(("quantity", "best design that is known"), rows)
    yield Text(
        "By branch and bound on enclosures of the objective and its derivatives over boxes, in doubles whose rounding "
        "is added to each: it rests on the arithmetic of IEEE 754, and on sines, cosines, arc tangents within 2^-49.",
        "note",
    )
