"""What a proof says of an optimum, key by key."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from planter.records import Record


@dataclass(frozen=True, kw_only=True)
class GlobalBound(Record):
    """No design of the box has an objective below `lower_bound`, which is null, with `gap`, if none was reached.

    `kind` is that of this objective: "sampled", over `samples` angles; nothing follows for true extremes then.
    `objective` is that of the incumbent `design`, the best that is known; `gap` is the difference.
    """

    kind: Literal["sampled", "true"]
    samples: int
    design: dict[str, float]
    objective: float
    lower_bound: float | None
    gap: float | None
    boxes: int
    seconds: float
    proved: bool
    statement: str
