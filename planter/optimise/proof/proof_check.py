"""Result of the check of a proof, key by key; importing it loads no numbers."""

from __future__ import annotations

from dataclasses import dataclass

from planter.records import Record


@dataclass(frozen=True, kw_only=True)
class ProofCheck(Record):
    """Whether a proof's bounds follow from what its file states; the reason if they do not.

    `lower_bound` is below the objectives of all designs, `incumbent` above that of the incumbent, `objective`; `gap` is
    the difference. `boxes` is the number of boxes that were bounded again.
    """

    valid: bool
    objective: float | None
    kind: str | None
    lower_bound: float | None
    incumbent: float | None
    gap: float | None
    boxes: int
    reason: str | None

    @classmethod
    def refuse(cls, reason: str) -> ProofCheck:
        """Return the check of a proof that is refused."""
        return cls(valid=False, objective=None, kind=None, lower_bound=None, incumbent=None, gap=None, boxes=0,
                   reason=reason)  # fmt: skip

    def describe(self) -> str:
        """Return a sentence for people."""
        if not self.valid:
            return f"refused: {self.reason}"
        bound = "nothing bounds the objective from below"
        if self.lower_bound is not None:
            bound = f"no design has an objective below {self.lower_bound:.10g}"
        incumbent = "" if self.incumbent is None else f", the incumbent's is at most {self.incumbent:.10g}"
        gap = "" if self.gap is None else f" (gap {self.gap:.2g})"
        return f"valid: {bound}{incumbent}{gap}; {self.boxes} boxes were bounded again"
