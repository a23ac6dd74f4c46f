"""What `planter audit` returns, key by key."""

from __future__ import annotations

from dataclasses import dataclass

from planter.files.record import Record


@dataclass(frozen=True)
class TermResult(Record):
    """A term of an equation, its largest size over the reference cycle, and that over the largest
    derived term's.
    """

    term: str
    max_abs: float | None
    unit: str
    share_of_largest: float | None


@dataclass(frozen=True)
class VanishingTerm(Record):
    """A term that vanishes, the reason, and whether the print has it."""

    term: str
    because: str
    printed: bool


@dataclass(frozen=True)
class ReadingVerdict(Record):
    """The verdict under one of the readings that the paper admits; `because` names the place that
    admits it.
    """

    reading: str
    because: str
    verdict: str
    finding: str


@dataclass(frozen=True)
class EquationResult(Record):
    """A printed equation: verdict, smallest corrections, missing and unexplained terms, the
    conditions of the verdict.

    The verdict is `not judged` if judging it raises an error; `finding` is the reason. `domain`
    says outside which range an equation is wrong although the machine does not leave it; it is
    empty for any other.

    `grade` is what a difference amounts to: `at fault`; `neglected` if terms are left out that are
    together below 1 % of the largest one over the cycle; `approximate` if the paper calls a number
    approximate that is off by less than 10 %; empty without a difference.

    `edited` is the print after the first of the corrections, empty if there is nothing to compare;
    with `terms` added and `unexplained` taken away, it is the derivation. `difference` is the sum
    of these terms, null if there are none.

    `transcription` is the print in its own symbols, order and signs, `printed` the same as it is
    read and simplified.

    `answer` is the reading that is taken of what the paper leaves open: the kindest one to all
    equations that share it. Of an equation that was read from a text, `file`, `line` and `latex`
    are its place and source, `corrected_latex` the source after the smallest change that makes it
    hold, empty if there is none.
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
    depends: list[ReadingVerdict]
    robust: bool
    domain: str
    grade: str
    reasons: list[str]
    terms: list[TermResult]
    unexplained: list[TermResult]
    edited: str
    difference: TermResult | None
    vanishing: list[VanishingTerm]
    transcription: str
    printed: str
    derived: str
    defines: str
    key: str
    file: str | None = None
    line: int | None = None
    latex: str | None = None
    corrected_latex: str | None = None


@dataclass(frozen=True)
class RowResult(Record):
    """A displayed equation of a text: its place, whether it is `read` or `refused`, and why it is
    not judged, if so.
    """

    file: str
    line: int
    status: str
    reason: str


@dataclass(frozen=True)
class EquationShare(Record):
    """Share of an equation in a broken law: reduction by its repair alone, remainder without it,
    Shapley value.
    """

    equation: str
    alone: float
    without: float
    shapley: float


@dataclass(frozen=True)
class LawResult(Record):
    """A law that the printed equations break as a whole, or keep, and the repairs that restore it.

    `violation` is null and `search` is `not judged` if the law cannot be evaluated; `owed` is the
    reason.

    `violation` is under the kindest joint `reading`, empty where the literal one is;
    `violation_literal` with every symbol read literally, as the printed model computes it.
    """

    paper: str
    law: str
    violation: float | None
    unit: str
    caused_by: list[str]
    or_by: list[list[str]]
    search: str
    shares: list[EquationShare]
    reading: str
    violation_literal: float | None
    key: str
    owed: str


@dataclass(frozen=True)
class PrintedNumberResult(Record):
    """A printed number, its recomputed value, and their difference; `place` is empty if it is
    unknown.

    `interval` is what the rounding of printed inputs leaves open, for a number that its nominal
    value misses; `reason` says why nothing was computed, where the computation did not succeed.
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
class CauseResult(Record):
    """One slip, its repair, and the equations and numbers that it explains."""

    paper: str
    cause: str
    repair: str
    equations: list[str]
    numbers: list[str]


@dataclass(frozen=True)
class ReferenceResult(Record):
    """Whether equations that a paper refers to give the quantities, and which do instead."""

    paper: str
    quantities: list[str]
    refers_to: list[str]
    verdict: str
    lacking: list[str]
    instead: list[str]


@dataclass(frozen=True)
class StatementResult(Record):
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
class ConsequenceResult(Record):
    """A number that depends on faulty equations: in the paper, by the equations as printed, as
    derived.
    """

    paper: str
    quantity: str
    unit: str
    printed: float | None
    as_printed: float | None
    as_derived: float | None
    rests_on: list[str]
    assumed_inputs: list[str]


@dataclass(frozen=True)
class PaperSummary(Record):
    """A paper: how often each verdict was given.

    `causes` are those of the equations at fault, and errors in disclosed inputs that printed numbers
    come from; each counts once.
    """

    title: str
    equations: dict[str, int]
    at_fault: int
    causes: int
    laws_violated: int
    numbers: dict[str, int]


@dataclass(frozen=True)
class AuditResult(Record):
    """`planter audit`; `rows` of a text."""

    equations: list[EquationResult]
    laws: list[LawResult]
    numbers: list[PrintedNumberResult]
    causes: list[CauseResult]
    references: list[ReferenceResult]
    claims: list[StatementResult]
    consequences: list[ConsequenceResult]
    summary: dict[str, PaperSummary]
    rows: list[RowResult] | None = None


@dataclass(frozen=True)
class BenchmarkText(Record):
    """A text of the corpus: rows displayed and read, sound equations and known errors, the time
    that it took.
    """

    name: str
    licence: str
    is_held_out: bool
    rows: int
    read_rows: int
    sound: int
    errata: int
    seconds: float


@dataclass(frozen=True)
class CheckerScore(Record):
    """Counts of a checker; what is refused is neither detected nor a false alarm.

    `detection` and `exact_repair` are shares of all slips, null without slips; `sound` counts
    equations as printed and rewritten ones.
    """

    slips: int
    detected: int
    repaired: int
    errata: int
    errata_found: int
    sound: int
    false_alarms: int
    refused: int
    detection: float | None
    exact_repair: float | None
    false_alarms_per_100: float | None


@dataclass(frozen=True)
class CheckerScores(Record):
    """Scores of a checker on all texts, on those that were held out, and by classes of slips."""

    all: CheckerScore
    held_out: CheckerScore
    classes: dict[str, CheckerScore]


@dataclass(frozen=True)
class AuditBenchmark(Record):
    """`planter audit --benchmark`: `absent` are texts of the corpus whose licence keeps them out of
    it.
    """

    seed: int
    texts: list[BenchmarkText]
    absent: list[str]
    checkers: dict[str, CheckerScores]


COMMANDS = {"audit": AuditResult, "audit benchmark": AuditBenchmark}
"""What the package's command returns."""
