"""Records of the audit: an entry for every equation, terms that vanish, and causes that entries
share.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from operator import itemgetter
from typing import Any

import mpmath
import sympy as sp
from sympy import Expr

from ..equations import Equation
from ..evaluate import Point
from ..quantity import NONE, Dimension, DimensionError, dimension, of_unit
from .case import Case
from .comparison import solve_for
from .evidence import write_evidence, write_unjudged
from .faults import Grade, find_relative_error, grade_fault, is_fragile, list_reasons
from .judge import FAULTS, Judgement, explain_unjudged
from .reading_search import Hearing, Outcome, derived_side, judge_linked_readings
from .terms import expand_sum, find_largest_size, holds
from .transcription import typeset_transcription
from .typesetting import Piece, Said, join_parts, typeset_equation, typeset_sentence

AT_FAULT: Grade = "at fault"
LACKS = "lacks "
"""How the reason of a finding begins that is an omission."""


def group_causes(records: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Every reason of a fault, once, with the equations of its paper that have it; the most shared
    first. What is neglected, or approximate, is no fault.

    An equation that lacks several things for one reason has the one that it shares with most
    others; if it shares none of them, all are one cause.
    """
    faulty = [record for record in records if record["grade"] == AT_FAULT]
    shared = Counter((r["paper"], reason) for r in faulty for reason in r["reasons"])
    records_by_cause: dict[tuple[str, str], list[Mapping[str, Any]]] = {}
    for record in faulty:
        for reason in _chosen(record, shared):
            records_by_cause.setdefault((record["paper"], reason), []).append(record)
    ranked = sorted(records_by_cause.items(), key=lambda item: -len(item[1]))
    return [_cause(paper, reason, members) for (paper, reason), members in ranked]


def _chosen(record: Mapping[str, Any], shared: Mapping[tuple[str, str], int]) -> list[str]:
    lacking = [reason for reason in record["reasons"] if reason.startswith(LACKS)]
    edits = [reason for reason in record["reasons"] if reason not in lacking]
    if not lacking:
        return edits
    commonest = max(lacking, key=lambda reason: shared[record["paper"], reason])
    if shared[record["paper"], commonest] == 1:
        commonest = LACKS + ", ".join(reason.removeprefix(LACKS) for reason in lacking)
    return [*edits, commonest]


def _cause(paper: str, reason: str, records: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    omitted = reason.startswith(LACKS)
    return {
        "paper": paper,
        "cause": f"{reason.removeprefix(LACKS)} is left out{_describe_share(records)}"
        if omitted
        else reason,
        "repair": f"add {_describe_terms(records[0])}" if omitted else reason,
        "equations": [f"{paper}: {record['equation']}" for record in records],
        "numbers": [],
    }


def _describe_share(records: Sequence[Mapping[str, Any]]) -> str:
    """Return in words how much a single equation lacks, empty if it is unknown or several equations
    lack it.
    """
    left = records[0].get("difference")
    if len(records) > 1 or not left or not left["share_of_largest"]:
        return ""
    return f", at most {format_share(left['share_of_largest'])} of the largest term"


def format_share(share: float) -> str:
    """Return a share as percent with two digits, or as many as it has before its point."""
    percent = 100 * share
    return f"{percent:.0f} %" if percent >= 10 else f"{percent:.2g} %"


def _describe_terms(record: Mapping[str, Any]) -> str:
    return ", ".join(term["term"] for term in record["terms"])


def describe_law_cause(law: Mapping[str, Any], equations: Mapping[str, Mapping[str, Any]]) -> str:
    """Return what is missing where, and by how much its repair alone reduces the violation of a
    broken law.

    The equation is that of the largest Shapley value. These values may be negative or exceed the
    violation, so none of them is reported as a part of it.
    """
    if not law["shares"]:
        return ""
    first = law["shares"][0]
    record = equations[first["equation"]]
    defect = f"it lacks {_describe_terms(record)}" if record["terms"] else _repair(record)
    left = max(law["violation"] - first["alone"], 0.0)
    sizes = f"from {law['violation']:.3g} to {left:.3g} {law['unit']}"
    return (
        f"Repairing ({record['equation']}) alone reduces the violation {sizes}: "
        f"{record['claims']}; {defect}."
    )


def _repair(record: Mapping[str, Any]) -> str:
    return (
        f"correct: {'; or '.join(record['correction'])}"
        if record["correction"]
        else str(record["finding"])
    )


@dataclass(frozen=True)
class Vanished:
    """A term, why it is zero, and whether the print has it."""

    term: Expr
    because: Said
    printed: bool


def find_vanishing_terms(case: Case, number: str, sign: Expr = sp.S.One) -> list[Vanished]:
    """List the terms that vanish: those of the derivation (times ``sign``), then those of the
    print.
    """
    return [*_derived(case, number, sign), *_read(case, number)]


def _derived(case: Case, number: str, sign: Expr) -> list[Vanished]:
    """Terms that the derivation has while the assumptions are lifted, and those that the print
    has.
    """
    reasons = case.assumed(number)
    if not reasons:  # nothing is multiplied out for nothing
        return []
    lifted = case.lifted(number)
    derived_terms = (
        [sign * t for t in _lost(expand_sum(lifted.residual), reasons, case.points)]
        if lifted
        else []
    )
    printed_terms = [
        t
        for t in expand_sum(case.paper.equations[number].residual)
        if t.free_symbols & reasons.keys()
    ]
    only_printed = [t for t in printed_terms if t not in derived_terms and -t not in derived_terms]
    terms = [(t, t in printed_terms or -t in printed_terms) for t in _sorted(derived_terms)] + [
        (t, True) for t in _sorted(only_printed)
    ]
    return [Vanished(term, _why(term, reasons), printed) for term, printed in terms]


def _lost(
    terms: Iterable[Expr], reasons: Mapping[sp.Symbol, str], points: list[Point]
) -> list[Expr]:
    """Terms with a quantity that is assumed to be zero, without those with another in common that
    cancel anyway.
    """
    unit = dict.fromkeys(reasons, sp.S.One)
    lost = [term for term in terms if term.free_symbols & reasons.keys()]
    for symbol in sorted(set().union(*(t.free_symbols for t in lost)) - reasons.keys(), key=str):
        shared = [term for term in lost if symbol in term.free_symbols]
        total = sp.Add(*(term.xreplace(unit) for term in shared))
        if len(shared) > 1 and holds(total, tuple(points)):
            lost = [term for term in lost if term not in shared]
    return lost


def _why(term: Expr, reasons: Mapping[sp.Symbol, str]) -> Said:
    symbols = sorted(term.free_symbols & reasons.keys(), key=str)
    return join_parts("; ", (Said(s, f" = 0: {reasons[s]}") for s in symbols))


def _read(case: Case, number: str) -> list[Vanished]:
    """Printed terms that cancel, or are zero, when the printed symbols are read as what they stand
    for.
    """
    reading = {
        s: e for s, e in case.symbol_meanings(number).items() if s not in case.assumed(number)
    }
    if not reading:
        return []
    terms = expand_sum(case.paper.equations[number].residual)
    left = {m for _, m in _split(expand_sum(sp.Add(*terms).xreplace(reading)))}
    vanished_terms = []
    for term in _sorted(terms):
        read = expand_sum(term.xreplace(reading))
        if not any(monomial in left for _, monomial in _split(read)):
            vanished_terms.append(Vanished(term, case.read_as(number), True))
    return vanished_terms


def _split(terms: tuple[Expr, ...]) -> list[tuple[Expr, Expr]]:
    return [term.as_coeff_Mul(rational=True) for term in terms]


def _sorted(terms: Iterable[Expr]) -> list[Expr]:
    return sorted(terms, key=sp.default_sort_key)


Record = dict[str, Any]
DIGITS = 6
MATHML, EVIDENCE = "mathml", "evidence"
"""Keys of what is typeset of a record, and of what repeats its verdict: written beside the records.
"""
_NAMED = ("1", "N", "N m", "N/m", "W")
_BASE = ("kg", "m", "s")


def index_records(
    records: Iterable[Record],
    typeset: Mapping[str, Mapping[str, Record]],
    evidence: Iterable[Record],
) -> dict[tuple[str, str], Record]:
    """Records of equations by paper and number, each with what is typeset of it and its evidence;
    others are left out.
    """
    proofs = {(proof["paper"], proof["equation"]): proof for proof in evidence}
    complete = {}
    for record in records:
        name = record["paper"], record["equation"]
        typeset_record = typeset.get(name[0], {}).get(name[1])
        if typeset_record is not None and name in proofs:
            complete[name] = {**record, MATHML: typeset_record, EVIDENCE: proofs[name]}
    return complete


def is_reusable(record: Record, key: str) -> bool:
    """Whether a record was made from the same as a new one would be."""
    return record.get("key") == key


def record_equations(case: Case, numbers: Sequence[str], key: str) -> list[Record]:
    """The findings on equations that are judged together.

    `not judged` with the reason where any step of it raises an error.
    """
    try:
        outcomes = judge_linked_readings(case, numbers[0])
    except Exception as error:  # one question must not end the audit of the others
        return [record_unjudged(case, number, key, error) for number in numbers]
    return [_attempted(case, number, key, outcomes[number]) for number in numbers]


def _attempted(case: Case, number: str, key: str, outcome: Outcome) -> Record:
    try:
        record = _recorded(case, number, key, outcome) | _place(case, number)
        return record if case.source else record | {EVIDENCE: write_evidence(case, number, outcome)}
    except Exception as error:  # one equation must not end the audit of the others
        return record_unjudged(case, number, key, error)


def _place(case: Case, number: str) -> Record:
    """Return where an equation stands in the text that it was read from; nothing if it was not."""
    return {} if case.source is None else case.source.describe(number)


def record_unjudged(case: Case, number: str, key: str, error: Exception) -> Record:
    """The record of an equation that cannot be judged, with the reason in `finding`."""
    printed = case.paper.equations[number]
    record = _build_record(case, printed, explain_unjudged(error), key, {})
    if _has_formula(case, printed):
        record["printed"] = _text(printed)
        try:
            record[MATHML]["printed"] = typeset_equation(printed)
        except Exception:  # what cannot be judged may be what cannot be set
            record[MATHML]["printed"] = typeset_sentence(record["printed"])
    return record | _place(case, number) | {EVIDENCE: write_unjudged(case, number)}


def _build_record(
    case: Case,
    printed: Equation,
    judgement: Judgement,
    key: str,
    parts: Mapping[str, Any],
    **facts: Any,
) -> Record:
    """Return a record of statements, which stand in it as text and typeset, and of facts."""
    statements = {
        "printed": "",
        "derived": "",
        "corrected": "",
        "finding": judgement.finding,
        "correction": [],
        "reading": "",
        "depends": [],
        "terms": [],
        "unexplained": [],
        "vanishing": [],
        **parts,
    }
    texts = _convert(statements, str)
    record = {
        "paper": case.paper.name,
        "equation": printed.number,
        "legibility": printed.legibility,
        "rebuilt": list(printed.rebuilt),
        "claims": str(printed.claims),
        "verdict": judgement.verdict,
        "finding": texts["finding"],
        "fragile": is_fragile(judgement),
        "correction": texts["correction"],
        "reading": texts["reading"],
        "answer": "",
        "depends": texts["depends"],
        "robust": True,
        "domain": str(judgement.domain),
        "grade": grade_fault(judgement, None, None),
        "reasons": list(list_reasons(judgement, printed, case.subject.actions())),
        "terms": [],
        "unexplained": [],
        "edited": "",
        "difference": None,
        "vanishing": [],
        "transcription": printed.typed if texts["printed"] and case.source is None else "",
        "printed": texts["printed"],
        "derived": texts["derived"],
        "defines": str(printed.defines or ""),
        "key": key,
        MATHML: _convert(statements, typeset_sentence),
    }
    if record["transcription"]:
        record[MATHML]["transcription"] = typeset_transcription(printed.typed)
    return record | facts


def _convert(part: Any, write: Callable[[Any], str]) -> Any:
    """Return statements written by a function of sentences: `str`, or what typesets them."""
    if isinstance(part, dict):
        return {name: _convert(value, write) for name, value in part.items()}
    if isinstance(part, list):
        return [_convert(value, write) for value in part]
    if isinstance(part, Equation):
        return _text(part) if write is str else typeset_equation(part)
    return write(part)


def _recorded(case: Case, number: str, key: str, outcome: Outcome) -> Record:
    """The record of an outcome."""
    hearing = outcome.kindest
    judgement, printed, derived = hearing.judgement, hearing.printed, hearing.derived
    meant = derived_side(case, hearing)
    flipped = derived and meant and meant.residual == -derived.residual
    gone = find_vanishing_terms(case, number, sp.S.NegativeOne if flipped else sp.S.One)
    missing, unexplained = _sorted(judgement.missing), _sorted(judgement.unexplained)
    left = sp.Add(*missing, *(-term for term in unexplained))
    difference = next(iter(_terms(case, [left] if left != 0 and meant else [], meant)), None)
    share = None if difference is None else difference["share_of_largest"]
    off = find_relative_error(printed, derived, case.points) if number in case.paper.rough else None
    if grade_fault(judgement, share, off) == "approximate":
        rough = f"printed as an approximation, {format_share(off or 0.0)} off"
        judgement = replace(judgement, finding=rough)
    shows = _has_formula(case, printed)
    read = [case.read_as(number), hearing.choice.meaning]
    edited = judgement.edited
    depends = [
        {
            "reading": h.choice.meaning,
            "because": h.choice.because,
            "verdict": h.judgement.verdict,
            "finding": _describe_finding(h.judgement),
        }
        for h in outcome.alternatives
    ]
    statements = {
        "printed": printed if shows else "",
        "derived": meant or "",
        "corrected": judgement.corrected if shows and judgement.corrected else "",
        "correction": [join_parts("; ", edits) for edits in judgement.corrections],
        "reading": join_parts("; ", filter(None, read)),
        "depends": depends,
        "terms": missing,
        "unexplained": unexplained,
        "vanishing": [{"term": v.term, "because": v.because} for v in gone],
    }
    return _build_record(
        case,
        printed,
        judgement,
        key,
        statements,
        answer=hearing.choice.meaning,
        robust=outcome.robust,
        terms=_terms(case, missing, meant),
        unexplained=_terms(case, unexplained, meant) if meant else [],
        edited="" if edited is None else _text(replace(printed, residual=edited)),
        grade=grade_fault(judgement, share, off),
        reasons=_list_reasons(case, hearing, judgement),
        difference=difference,
        vanishing=[
            {"term": str(v.term), "because": str(v.because), "printed": v.printed} for v in gone
        ],
    )


SHORT = 60
"""Characters of a formula that stands in a sentence."""


def _list_reasons(case: Case, hearing: Hearing, judgement: Judgement) -> list[str]:
    """List the faults of an equation in words; of one that says that a quantity is a number, and of
    a condition, in a sentence.
    """
    printed, derived = hearing.printed, hearing.derived
    symbol = printed.defines
    if judgement.verdict in FAULTS and symbol is not None and derived is not None:
        side, meant = (solve_for(e.residual, symbol) for e in (printed, derived))
        size = find_largest_size(meant, case.dense_cycle)
        if side.is_Rational and size is not None and not judgement.edits:
            unit = "" if symbol.unit == "1" else f" {symbol.unit}"
            is_short = len(str(meant)) <= SHORT
            value = f"is {meant}" if is_short else f"reaches {mpmath.nstr(size, 3)}{unit}"
            return [f"{symbol.meaning} is said to be {side}, and {value}"]
    if judgement.verdict == "contradicted" and derived is not None and printed.relation != "=":
        stated, needed = map(_format_condition, (printed, derived))
        return [f"{printed.claims}: {stated} is said, and {needed} is needed"]
    actions, reactions = case.subject.actions(), case.subject.reactions()
    return list(list_reasons(judgement, printed, actions, reactions, case.cycle))


def _format_condition(equation: Equation) -> str:
    """Return a condition with what is taken away on its other side."""
    terms = sp.Add.make_args(equation.residual)
    right = [term for term in terms if term.could_extract_minus_sign()]
    left = sp.Add(*(term for term in terms if term not in right))
    return f"{left} {equation.relation} {-sp.Add(*right)}"


def _describe_finding(judgement: Judgement) -> Said:
    """A finding with its correction or the number of its missing terms."""
    parts: list[Piece] = [join_parts("; ", edits) for edits in judgement.corrections[:1]]
    parts += [f"{len(judgement.missing)} missing"] if judgement.missing else []
    return (
        Said(judgement.finding, ": ", join_parts("; ", parts))
        if parts and not judgement.unexplained
        else Said(judgement.finding)
    )


def _has_formula(case: Case, printed: Equation) -> bool:
    """Return whether an equation can be shown by its residual: not if it is lost, nor if its text
    alone has it.
    """
    return printed.residual != 0 or (printed.legibility != "lost" and case.source is None)


def _text(equation: Equation) -> str:
    return f"{equation.residual} {equation.relation} 0"


def _terms(case: Case, terms: Sequence[Expr], derived: Equation | None) -> list[Record]:
    """Terms with their largest size over the cycle, with that of the largest derived term; null
    without a value.
    """
    if not terms:
        return []
    sizes = (
        [_size(t, case) or mpmath.mpf(0) for t in expand_sum(derived.residual)] if derived else []
    )
    return [_term(t, _size(t, case), max(sizes, default=None)) for t in terms]


def _size(term: Expr, case: Case) -> mpmath.mpf | None:
    return find_largest_size(term, case.dense_cycle)


def _term(term: Expr, size: mpmath.mpf | None, largest: mpmath.mpf | None) -> Record:
    share = size / largest if size is not None and largest else None
    return {
        "term": str(term),
        "max_abs": _rounded(size),
        "unit": find_unit(term),
        "share_of_largest": _rounded(share),
    }


def _rounded(value: mpmath.mpf | None) -> float | None:
    return None if value is None else float(mpmath.nstr(value, DIGITS))


def find_unit(expr: Expr) -> str:
    """A unit of the dimension of an expression; a question mark where it mixes dimensions."""
    try:
        expr_dimension = dimension(expr) or NONE
    except DimensionError:
        return "?"
    return next((u for u in _NAMED if of_unit(u) == expr_dimension), None) or _composed(
        expr_dimension
    )


def _composed(exponents: Dimension) -> str:
    """A unit such as ``kg m/s2``."""
    above, below = (
        " ".join(
            f"{u}{abs(n) if abs(n) != 1 else ''}"
            for u, n in zip(_BASE, exponents, strict=True)
            if sign * n > 0
        )
        for sign in (1, -1)
    )
    return f"{above or 1}/{below}" if below else above


def count_verdicts(
    records: Iterable[Record], name: Callable[[Record], str] = itemgetter("verdict")
) -> dict[str, dict[str, int]]:
    """Count each verdict by paper, under its name."""
    counts: dict[str, Counter[str]] = {}
    for record in records:
        counts.setdefault(record["paper"], Counter())[name(record)] += 1
    return {paper: dict(sorted(counter.items())) for paper, counter in counts.items()}


def format_records(
    records: Sequence[Record],
    laws: Sequence[Record],
    references: Sequence[Record],
    papers: Mapping[str, Record],
    rows: Sequence[Record] = (),
) -> str:
    """Format all records without typesetting; ``papers`` hold title and model by name, ``rows``
    those of texts.
    """
    plain = [
        {key: part for key, part in record.items() if key not in (MATHML, EVIDENCE)}
        for record in records
    ]
    content = {
        "equations": plain,
        "laws": list(laws),
        "causes": group_causes(records),
        "references": list(references),
    }
    texts = {"rows": list(rows)} if rows else {}
    return _json(content | texts | {"papers": papers, "summary": count_verdicts(records)})


def format_typeset(records: Iterable[Record]) -> str:
    """Paper -> equation -> what is typeset of its record: MathML of formulas, sentences with MathML
    in them.
    """
    content: dict[str, dict[str, Record]] = {}
    for record in records:
        content.setdefault(record["paper"], {})[record["equation"]] = record[MATHML]
    return _json(content)


def _json(content: object) -> str:
    return json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
