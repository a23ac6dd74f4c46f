"""Result of the check of a proof, key by key; importing it loads no numbers."""

from __future__ import annotations

from dataclasses import dataclass, field

from planter.files.record import Record


@dataclass(frozen=True, kw_only=True)
class ProofCheck(Record):
    """Whether a proof's bounds follow from what its file states; the reason if they do not.

    `lower_bound` is below the objectives of all designs, `incumbent` above that of the incumbent,
    `objective`; `gap` is the difference. `boxes` is the number of boxes that were bounded again.
    `statement` says in words what was proved; the generated modules `compared` are, here, those
    that the programs were recorded from.
    """

    valid: bool
    objective: float | None
    kind: str | None
    lower_bound: float | None
    incumbent: float | None
    gap: float | None
    boxes: int
    reason: str | None
    statement: str | None = None
    compared: list[str] = field(default_factory=list)

    @classmethod
    def refuse(cls, reason: str) -> ProofCheck:
        """Return the check of a proof that is refused."""
        return cls(
            valid=False,
            objective=None,
            kind=None,
            lower_bound=None,
            incumbent=None,
            gap=None,
            boxes=0,
            reason=reason,
        )

    def describe(self) -> str:
        """Return a sentence for people."""
        if not self.valid:
            return f"refused: {self.reason}"
        modules = (
            ", ".join(self.compared) or "nothing, as none of its generated code is installed here"
        )
        return (
            f"valid: {self.statement} {self.boxes} boxes were bounded again. Generated code that "
            f"is the same here: "
            f"{modules}. Not compared: whether the programs are those of the machine."
        )
