"""What `planter audit` returns, key by key."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from planter.records import Record


@dataclass(frozen=True)
class Term(Record):
    """A term of an equation, its largest size over the reference cycle, and that over the largest derived term's."""

    term: str
    max_abs: float | None
    unit: str
    share_of_largest: float | None


@dataclass(frozen=True)
class Vanishing(Record):
    """A term that does not show, why, and whether the print has it."""

    term: str
    because: str
    printed: bool


@dataclass(frozen=True)
class Depends(Record):
    """The verdict under one of the readings that the paper admits; `because` names the place that admits it."""

    reading: str
    because: str
    verdict: str
    finding: str


@dataclass(frozen=True)
class Equation(Record):
    """A printed equation: verdict, smallest corrections, missing and unexplained terms, what the verdict hangs on.

    The verdict is `not judged` where judging it raises an error; `finding` is the reason. `domain` says where an
    equation does not hold that holds wherever the machine uses it; it is empty for any other.

    `answer` is the reading that is taken of what the paper leaves open: the kindest one to all equations that share it.
    """

    paper: str
    equation: str
    legibility: str
    rebuilt: list[str]
    claims: str
    verdict: str
    finding: str
    fragile: bool
    correction: list[str]
    reading: str
    answer: str
    depends: list[Depends]
    robust: bool
    domain: str
    reasons: list[str]
    terms: list[Term]
    unexplained: list[Term]
    vanishing: list[Vanishing]
    printed: str
    derived: str
    defines: str
    key: str


@dataclass(frozen=True)
class Share(Record):
    """What an equation does to a broken law: its repair alone takes away, it alone leaves, its Shapley value."""

    equation: str
    alone: float
    without: float
    shapley: float


@dataclass(frozen=True)
class Law(Record):
    """A law that the printed equations break as a whole, or keep, and the repairs that restore it.

    `violation` is null and `search` is `not judged` where the law cannot be tried; `owed` says why.

    `violation` is under the kindest joint `reading`, empty where the literal one is; `violation_literal` with every
    symbol read literally, as the printed model computes it.
    """

    paper: str
    law: str
    violation: float | None
    unit: str
    caused_by: list[str]
    or_by: list[list[str]]
    search: str
    shares: list[Share]
    reading: str
    violation_literal: float | None
    key: str
    owed: str


@dataclass(frozen=True)
class Number(Record):
    """A printed number, what it comes to, and by how much that differs; `place` is where it is printed, if told.

    `interval` is what the rounding of printed inputs leaves open, for a number that its nominal value misses; `reason`
    says why nothing was computed, where the computation did not succeed.
    """

    paper: str
    place: str
    quantity: str
    unit: str
    printed: float
    recomputed: float | None
    interval: list[float] | None
    difference: float | None
    verdict: str
    assumed_inputs: list[str]
    needs: list[str]
    printed_text: str
    reading: str
    reason: str
    formula: str
    cured_by: str
    cured_to: float | None


@dataclass(frozen=True)
class Cause(Record):
    """One slip, its repair, and the equations and numbers that it explains."""

    paper: str
    cause: str
    repair: str
    equations: list[str]
    numbers: list[str]


@dataclass(frozen=True)
class Reference(Record):
    """Whether equations that a paper refers to give the quantities, and which do instead."""

    paper: str
    quantities: list[str]
    refers_to: list[str]
    verdict: str
    lacking: list[str]
    instead: list[str]


@dataclass(frozen=True)
class Statement(Record):
    """A statement of a paper's text, what was measured of it, and whether it holds."""

    paper: str
    claim: str
    measure: str
    value: float | None
    unit: str
    must: str
    holds: bool
    assumed_inputs: list[str]


@dataclass(frozen=True)
class Consequence(Record):
    """What equations at fault do to a number: in the paper, by the equations as printed, as derived."""

    paper: str
    about: str
    quantity: str
    unit: str
    printed: float | None
    as_printed: float | None
    as_derived: float | None
    rests_on: list[str]
    statement: str
    assumed_inputs: list[str]


@dataclass(frozen=True)
class Summary(Record):
    """A paper: how often each verdict was given."""

    title: str
    equations: dict[str, int]
    at_fault: int
    causes: int
    laws_violated: int
    numbers: dict[str, int]


@dataclass(frozen=True)
class Audit(Record):
    """`planter audit`; `front` with `--front` alone, in the words of the machine that it is of."""

    equations: list[Equation]
    laws: list[Law]
    numbers: list[Number]
    causes: list[Cause]
    references: list[Reference]
    claims: list[Statement]
    consequences: list[Consequence]
    summary: dict[str, Summary]
    front: dict[str, Any] | None = None


COMMANDS = {"audit": Audit}
"""What the package's command returns."""
