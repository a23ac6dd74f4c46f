"""Results of proofs and of their checks, key by key; importing them loads no numbers."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from planter.files.record import Record


@dataclass(frozen=True, kw_only=True)
class GlobalBound(Record):
    """No design of the box has an objective below `lower_bound`, which is null, with `gap`, if none
    was reached.

    `kind` is that of this objective: "true", of true extremes and integrals, or "sampled", over
    `samples` angles, from which nothing follows for true extremes. `objective` is that of the
    incumbent `design`, the best that is known; `gap` is the difference. `seconds` are those of all
    cores.
    """

    kind: Literal["sampled", "true"]
    samples: int | None
    design: dict[str, float]
    objective: float
    lower_bound: float | None
    gap: float | None
    boxes: int
    seconds: float
    proved: bool
    statement: str


@dataclass(frozen=True, kw_only=True)
class ProofCheck(Record):
    """Whether a proof's bounds follow from what its file states; the reason if they do not.

    `lower_bound` is below the objectives of all designs, `incumbent` above that of the incumbent,
    `objective`; `gap` is the difference. `boxes` is the number of boxes that were bounded again.
    `statement` says in words what was proved, `trusted` what was taken as the file states it. The
    programs and the assembly were `compared` with those of these machines, as generated here.
    """

    valid: bool
    objective: float | None = None
    kind: str | None = None
    lower_bound: float | None = None
    incumbent: float | None = None
    gap: float | None = None
    boxes: int = 0
    reason: str | None = None
    statement: str | None = None
    compared: list[str] = field(default_factory=list)
    trusted: list[str] = field(default_factory=list)

    def describe(self) -> str:
        """Return a sentence for people."""
        if not self.valid:
            return f"refused: {self.reason}"
        compared = (
            f"Programs and assembly are those of {', '.join(self.compared)} as generated here."
            if self.compared
            else "Not compared: whether the programs are those of a machine."
        )
        return f"valid: {self.statement} {self.boxes} boxes were bounded again. {compared}"
