"""A benchmark of formula audits: texts with known errors, slips drawn into sound equations,
rewrites of them.

A corpus is a folder of texts, each in a folder with ``source.toml``, ``mechanism.py``,
``names.toml`` and the text itself, if its licence allows that; ``held_out`` in its source says why
a text is held out. Any checker can be scored: its answers say of each claim whether it holds, and
what it should be.
"""

from __future__ import annotations

import hashlib
import json
import random
import sys
import time
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain
from multiprocessing import get_context
from pathlib import Path
from typing import Any, Literal

import mpmath
from sympy import Expr

from ...equations import Definition
from ...evaluate import DIGITS, TOLERANCE, NotEvaluated, Point
from ...generated_folder import OwnError
from ..terms import holds, list_unknown
from .changes import SLIPS, PrintedFormula, list_rewrites
from .corrections import UNREADABLE
from .documents import SUFFIXES, read_document
from .formula import expand_matrix_macros, read_formula
from .interpretation import interpret_formula
from .names import NameTable, find_stated, read_name_table
from .trial import PrintedText, ReadRow, load_module, read_case

SOURCE, MECHANISM, NAMES, TEXT = "source.toml", "mechanism.py", "names.toml", "text"
Kind = Literal["sound", "erratum", "rewrite", "slip"]
Outcome = Literal["holds", "fails", "refused"]
SAMPLES = 4
"""Random values at which two readings are compared."""
ZERO = 1e-30
"""Size of a residual at values of the size of one that is rounding."""


@dataclass(frozen=True)
class CorpusText:
    """A text of a corpus: its folder, what ``source.toml`` says, and its file, None if nobody has
    fetched it.
    """

    folder: Path
    table: Mapping[str, Any]
    file: Path | None

    @property
    def name(self) -> str:
        """The name of its folder."""
        return self.folder.name

    @property
    def is_original(self) -> bool:
        """Whether the file is the whole original, of which only the lines count that the corpus
        takes.
        """
        return self.file is not None and self.file.stem != TEXT

    @property
    def is_held_out(self) -> bool:
        """Whether the text is none of those that the audit may be tuned by, for the reason that
        ``held_out`` gives.
        """
        return bool(self.table.get("held_out"))

    @property
    def errata(self) -> Mapping[str, str]:
        """Rows with known errors, with their LaTeX as it should be."""
        return {str(entry["row"]): entry["corrected"] for entry in self.table.get("errata", ())}


@dataclass(frozen=True)
class BenchmarkClaim:
    """A row that a checker judges: its text, its LaTeX, and what it is.

    ``kind`` is that of the claim, ``slip`` the class of a slip, ``correct`` the LaTeX without the
    error.
    """

    text: str
    row: str
    latex: str
    kind: Kind
    slip: str = ""
    correct: str = ""
    is_held_out: bool = False

    @property
    def key(self) -> str:
        """A name of the claim that depends on nothing but the text and the change."""
        digest = hashlib.sha256(self.latex.encode()).hexdigest()[:8]
        return f"{self.text}:{self.row}:{self.kind}:{digest}"


@dataclass(frozen=True)
class CheckerAnswer:
    """Outcome of a claim by a checker, and whether its correction is right."""

    outcome: Outcome
    is_exact: bool = False


def read_corpus(folder: Path) -> list[CorpusText]:
    """Return the texts of a corpus.

    Raises OwnError for a folder without texts, and for a text with another hash.
    """
    texts = []
    for source in sorted(folder.glob(f"*/{SOURCE}")):
        table = tomllib.loads(source.read_text(encoding="utf-8"))
        texts.append(CorpusText(source.parent, table, _find_text(source.parent, table)))
    if not texts:
        raise OwnError(
            f"{folder}: it has no text: there must be folders with {SOURCE}, {MECHANISM} and "
            f"{NAMES}"
        )
    return texts


def _find_text(folder: Path, table: Mapping[str, Any]) -> Path | None:
    """Return the file of a text: the equations that stand in the corpus, or the original that
    somebody fetched.
    """
    for suffix in SUFFIXES:
        if (folder / f"{TEXT}{suffix}").is_file():
            return folder / f"{TEXT}{suffix}"
    original = folder / Path(table["path"]).name
    if not original.is_file():
        return None
    if hashlib.sha256(original.read_bytes()).hexdigest() != table["sha256"]:
        raise OwnError(
            f"{original}: it is not the text of commit {table['commit']}: its hash differs"
        )
    return original


class TextClaims:
    """The equations of a text that are judged, and what is drawn from them."""

    def __init__(self, text: CorpusText, table: NameTable | None = None) -> None:
        assert text.file is not None
        begun = time.perf_counter()
        module = load_module(text.folder / MECHANISM)
        table = read_name_table(text.folder / NAMES) if table is None else table
        case = read_case(read_document(text.file), find_stated(module), table, module)
        assert isinstance(case.source, PrintedText)
        self.text, self.printed, self.points, self.draw_points = (
            text,
            case.source,
            list(case.points),
            case.draw,
        )
        first, last = (
            text.table["lines"] if text.is_original and "lines" in text.table else (0, sys.maxsize)
        )
        self.rows = [row for row in self.printed.rows if first <= row.row.line <= last]
        self.vocabulary = self.printed.list_vocabulary()
        self._names = {row.row.number: row.names for row in self.rows}
        self.sound: list[BenchmarkClaim] = []
        self.errata: list[BenchmarkClaim] = []
        places, equations = self.printed.places.items(), case.paper.equations
        judged = {
            place.row.row.number
            for name, place in places
            if not isinstance(equations[name].claims, Definition)
        }
        for row in self.rows:
            if row.row.number in judged and not row.reason:
                self._add_claim(row)
        self.seconds = time.perf_counter() - begun

    def _add_claim(self, row: ReadRow) -> None:
        number, errata = row.row.number, self.text.errata
        claim = BenchmarkClaim(
            self.text.name, number, row.row.latex, "sound", is_held_out=self.text.is_held_out
        )
        reading = self.read(claim.latex, claim)
        if reading is None or not all(part.is_equation for part in reading):
            return
        if number in errata and self.judge(claim) != "holds":
            correct = expand_matrix_macros(errata[number], self.printed.document.macros)
            self.errata.append(replace(claim, kind="erratum", correct=correct))
        else:
            self.sound.append(claim)

    def read(self, latex: str, claim: BenchmarkClaim) -> list[EquationReading] | None:
        """Return the residuals of a row in the place of a claim, None if it cannot be read or
        states nothing.
        """
        names = self._names.get(claim.row, self.printed.names)
        try:
            residuals = interpret_formula(
                read_formula(latex, self.printed.document.macros), names
            ).residuals(names)
            return [
                EquationReading(left.value - right.value, (left + (-right)).mixed, relation == "=")
                for _, relation, left, right in residuals
            ] or None
        except UNREADABLE:
            return None

    def judge(self, claim: BenchmarkClaim) -> Outcome:
        """Return whether a claim holds at the points of the motion, whatever its units."""
        reading = self.read(claim.latex, claim)
        if reading is None:
            return "refused"
        if any(list_unknown(part.residual, self.points) for part in reading):
            return "refused"
        return "holds" if all(map(self._holds, reading)) else "fails"

    def _holds(self, part: EquationReading) -> bool:
        return holds(part.residual, tuple(self.points))

    def draw(self, count: int, seed: int) -> list[BenchmarkClaim]:
        """Return a rewrite of each sound equation, and slips in them, as equally many of each class
        as there are.
        """
        rng = random.Random(f"{seed} {self.text.name}")
        claims: dict[str, BenchmarkClaim] = {}
        printed = {
            claim: self._formula(claim) for claim in self.sound if self.judge(claim) == "holds"
        }
        for claim, formula in printed.items():
            changed = [change.apply(claim.latex) for change in list_rewrites(formula)]
            same = [latex for latex in changed if latex != claim.latex]
            if same:
                other = replace(claim, kind="rewrite", latex=rng.choice(same), correct=claim.latex)
                claims[other.key] = other
        for slip, list_changes in SLIPS.items():
            changes = [
                (claim, change)
                for claim, formula in printed.items()
                for change in list_changes(formula)
            ]
            rng.shuffle(changes)
            self._select_slips(slip, changes, -(-count // len(SLIPS)), claims)
        return list(claims.values())

    def _select_slips(
        self,
        slip: str,
        changes: Iterable[tuple[BenchmarkClaim, Any]],
        count: int,
        claims: dict[str, BenchmarkClaim],
    ) -> None:
        """Add slips that can be read and say something else than the sound row, in any values."""
        goal = len(claims) + count
        for claim, change in changes:
            if len(claims) == goal:
                return
            latex = change.apply(claim.latex)
            if self.read(latex, claim) is not None and not self.is_same(latex, claim.latex, claim):
                slipped = replace(claim, kind="slip", slip=slip, latex=latex, correct=claim.latex)
                claims.setdefault(slipped.key, slipped)

    def _formula(self, claim: BenchmarkClaim) -> PrintedFormula:
        return PrintedFormula.read(
            claim.latex, self.printed.document.macros, self._names[claim.row], self.vocabulary
        )

    def is_same(self, latex: str, other: str, claim: BenchmarkClaim) -> bool:
        """Return whether two rows in the place of a claim say the same for any values, up to
        factors.
        """
        first, second = self.read(latex, claim), self.read(other, claim)
        return (
            first is not None
            and second is not None
            and len(first) == len(second)
            and all(
                _are_proportional(a.residual, b.residual)
                for a, b in zip(first, second, strict=True)
            )
        )

    def answer(self, claim: BenchmarkClaim) -> CheckerAnswer:
        """Return what this audit says of a claim, and whether its first correction says what is
        right.
        """
        outcome = self.judge(claim)
        if outcome != "fails" or not claim.correct:
            return CheckerAnswer(outcome)
        parts = enumerate(self.read(claim.latex, claim) or ())
        index = next(i for i, part in parts if not self._holds(part))
        names = self._names.get(claim.row, self.printed.names)
        repair = self.printed.correct(claim.latex, index, names, self.points, self.draw_points)
        return CheckerAnswer(
            outcome, repair is not None and self.is_same(repair.latex, claim.correct, claim)
        )

    def answer_by_units(self, claim: BenchmarkClaim) -> CheckerAnswer:
        """Return what a checker of units alone says of a claim."""
        reading = self.read(claim.latex, claim)
        if reading is None:
            return CheckerAnswer("refused")
        return CheckerAnswer("fails" if any(part.mixed for part in reading) else "holds")


@dataclass(frozen=True)
class EquationReading:
    """The residual of an equation, whether it adds what has other units, and whether it is no
    inequality.
    """

    residual: Expr
    mixed: bool
    is_equation: bool


def _are_proportional(first: Expr, second: Expr) -> bool:
    """Return whether one residual is a multiple of the other for any values of their symbols."""
    if first == second:
        return True
    symbols = sorted(first.free_symbols | second.free_symbols, key=str)
    rng, ratios = random.Random(1), []
    with mpmath.workdps(DIGITS):
        for _ in range(SAMPLES):
            point = Point({symbol: mpmath.mpf(rng.uniform(0.2, 1.3)) for symbol in symbols})
            try:
                left, right = point(first), point(second)
            except (NotEvaluated, ZeroDivisionError, TypeError):
                return False
            if abs(left) > ZERO or abs(right) > ZERO:
                ratios.append(left / right if abs(right) > ZERO else mpmath.inf)
        return all(abs(ratio - ratios[0]) <= TOLERANCE * abs(ratios[0]) for ratio in ratios)


Answers = Mapping[str, tuple[CheckerAnswer, ...]]
"""The answers to claims by checker."""
OWN, UNITS, UNNAMED = "planter", "units", "planter without names"


def judge_corpus_text(
    text: CorpusText, slips: int, seed: int
) -> tuple[dict[str, Any], tuple[BenchmarkClaim, ...], Answers]:
    """Return a text's part of the result, its claims, with `slips` slips of all classes together,
    and the answers of this audit.
    """
    audit, unnamed = TextClaims(text), TextClaims(text, NameTable())
    claims = (*audit.sound, *audit.errata, *audit.draw(slips, seed))
    begun = time.perf_counter()
    answers = {
        OWN: tuple(audit.answer(claim) for claim in claims),
        UNNAMED: tuple(unnamed.answer(claim) for claim in claims),
        UNITS: tuple(audit.answer_by_units(claim) for claim in claims),
    }
    summary = {
        "name": text.name,
        "licence": text.table["licence"],
        "is_held_out": text.is_held_out,
        "rows": len(audit.rows),
        "read_rows": sum(row.chain is not None for row in audit.rows),
        "sound": len(audit.sound),
        "errata": len(audit.errata),
        "seconds": audit.seconds + time.perf_counter() - begun,
    }
    return summary, claims, answers


def run_benchmark(
    folder: Path, slips: int, seed: int, answers: Path | None = None
) -> dict[str, Any]:
    """Score this audit, a checker of units, and, with its answers, another checker on a corpus.

    ``slips`` is their number in all texts together; a text has as many as its share of the texts.
    Raises OwnError as `read_corpus`, and for a file of answers that cannot be used.
    """
    corpus = read_corpus(folder)
    present = [text for text in corpus if text.file is not None]
    if not present:
        raise OwnError(f"{folder}: none of its texts has been fetched")
    judge = partial(judge_corpus_text, slips=-(-slips // len(present)), seed=seed)
    with ProcessPoolExecutor(mp_context=get_context("spawn")) as pool:
        results = list(pool.map(judge, present))
    summaries, claims_by_text, answers_by_text = zip(*results, strict=True)
    claims = list(chain.from_iterable(claims_by_text))
    by_checker = {
        name: [a for by_name in answers_by_text for a in by_name[name]]
        for name in (OWN, UNNAMED, UNITS)
    }
    if answers is not None:
        by_checker[answers.stem] = _read_answers(answers, claims)
    return {
        "seed": seed,
        "texts": summaries,
        "absent": [text.name for text in corpus if text.file is None],
        "checkers": {
            name: score_answers(claims, answered) for name, answered in by_checker.items()
        },
        "claims": [
            {"key": claim.key, "latex": claim.latex, "text": claim.text} for claim in claims
        ],
    }


def _read_answers(path: Path, claims: Sequence[BenchmarkClaim]) -> list[CheckerAnswer]:
    """Return the answers in a file of JSON lines, in the order of the claims; a claim without one
    is refused.
    """
    by_key: dict[str, CheckerAnswer] = {}
    correct = {claim.key: claim.correct for claim in claims}
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        try:
            entry = json.loads(line)
            outcome, latex = entry["outcome"], entry.get("latex", "")
            is_exact = bool(latex) and "".join(latex.split()) == "".join(
                correct[entry["key"]].split()
            )
        except (json.JSONDecodeError, KeyError, TypeError, AttributeError):
            raise OwnError(
                f"{path}, line {number}: it must be an object with the key of a claim and an "
                f"outcome"
            ) from None
        if outcome not in ("holds", "fails", "refused"):
            raise OwnError(
                f"{path}, line {number}: outcome = {outcome!r}: it must be holds, fails or refused"
            )
        by_key[entry["key"]] = CheckerAnswer(outcome, is_exact)
    return [by_key.get(claim.key, CheckerAnswer("refused")) for claim in claims]


def score_answers(
    claims: Sequence[BenchmarkClaim], answers: Sequence[CheckerAnswer]
) -> dict[str, Any]:
    """Return the scores of a checker: on all texts, on those held out, and of each class of
    slips.
    """
    pairs = list(zip(claims, answers, strict=True))
    held_out = [pair for pair in pairs if pair[0].is_held_out]
    classes = {slip: [pair for pair in pairs if pair[0].slip == slip] for slip in SLIPS}
    return {
        "all": _count(pairs),
        "held_out": _count(held_out),
        "classes": {slip: _count(some) for slip, some in classes.items()},
    }


def _count(pairs: Sequence[tuple[BenchmarkClaim, CheckerAnswer]]) -> dict[str, Any]:
    """Count slips, errata and sound rows; what is refused is neither detected nor a false alarm."""
    slips, errata, rest = (
        [answer for claim, answer in pairs if claim.kind in kinds]
        for kinds in (("slip",), ("erratum",), ("sound", "rewrite"))
    )
    detected, repaired = sum(a.outcome == "fails" for a in slips), sum(a.is_exact for a in slips)
    sound, alarms = (
        sum(a.outcome != "refused" for a in rest),
        sum(a.outcome == "fails" for a in rest),
    )
    return {
        "slips": len(slips),
        "detected": detected,
        "repaired": repaired,
        "errata": len(errata),
        "errata_found": sum(a.outcome == "fails" for a in errata),
        "sound": sound,
        "false_alarms": alarms,
        "refused": sum(a.outcome == "refused" for _, a in pairs),
        "detection": detected / len(slips) if slips else None,
        "exact_repair": repaired / len(slips) if slips else None,
        "false_alarms_per_100": 100 * alarms / sound if sound else None,
    }
