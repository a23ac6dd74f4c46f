"""Audit of papers: verdicts on every equation and law, as data and as a page."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from contextlib import ExitStack
from functools import cache
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType
from typing import Any

from . import key
from .case import Case, judge_references
from .evidence import format_evidence
from .judge import UNJUDGED
from .laws import ChainLaws, attempted_violation, judge_laws, record_untried_law
from .record import (
    AT_FAULT,
    EVIDENCE,
    Record,
    count_verdicts,
    describe_law_cause,
    format_records,
    format_share,
    format_typeset,
    group_causes,
    index_records,
    is_reusable,
    record_equations,
)

SILENT = ("confirmed", "confirmed as rebuilt", "definition", "untested")
"""Verdicts that leave nothing to say but what a symbol is read as or what vanishes."""
LAW_DIGITS = 4
SOURCE = (
    "The machine-read text of each paper was audited, not its page images. Gaps that were filled "
    "in are listed",
    "(`confirmed as rebuilt`); where the text is lost, only the derivation is given "
    "(`reconstructed`). A finding that",
    "depends on one character may be an error of reading. If a symbol is ambiguous, every "
    "admissible reading is tried.",
    "Equations that share a symbol are judged under one meaning of it: the joint reading most "
    "favourable to all of",
    "them decides, and the verdicts under the others are listed. One mistake in several equations "
    "counts once.",
)


def as_page(
    records: Sequence[Record],
    titles: Mapping[str, str],
    laws: Sequence[Record] = (),
    references: Sequence[Record] = (),
) -> str:
    """The findings to read: a table and, where there is something to say, a paragraph for each
    equation; the laws.
    """
    lines = [
        "# Formula audit",
        "",
        "Written by `python -m derive audit`; do not edit.",
        "",
        *SOURCE,
        "",
        *format_overview(records),
    ]
    for paper, counts in count_verdicts(records, describe_verdict).items():
        paper_records = [r for r in records if r["paper"] == paper]
        summary = ", ".join(f"{n} {word}" for word, n in counts.items())
        lines += [f"## {titles[paper]}", "", f"{summary}.", "", *_causes(paper_records)]
        lines += _table(
            "equation | claims to be | legibility | verdict | depends on", map(_row, paper_records)
        )
        for record in paper_records:
            lines += _paragraph(record)
        for reference in references:
            lines += _reference(reference) if reference["paper"] == paper else []
    return "\n".join([*lines, *_list_laws(laws)])


def _table(head: str, rows: Iterable[Iterable[object]]) -> list[str]:
    """Return a table under a head of cells, nothing without rows."""
    lines = [f"| {' | '.join(map(str, row))} |" for row in rows]
    columns = head.count(" | ") + 1
    return [f"| {head} |", f"|{'---|' * columns}", *lines, ""] if lines else []


def format_overview(records: Sequence[Record]) -> list[str]:
    """A table of the papers: verdicts, equations at fault, causes, and what depends on a reading or
    a character.
    """
    rows = []
    for paper, counts in count_verdicts(records, describe_verdict).items():
        paper_records = [r for r in records if r["paper"] == paper]
        rows.append(
            (
                paper,
                ", ".join(f"{n} {word}" for word, n in counts.items()),
                sum(r["grade"] == AT_FAULT for r in paper_records),
                len(group_causes(paper_records)),
                sum(not r["robust"] for r in paper_records),
                sum(r["fragile"] for r in paper_records),
            )
        )
    head = "paper | verdicts | at fault | causes of these | on a reading | on one character"
    return _table(head, rows)


def _reference(reference: Record) -> list[str]:
    """A cross-reference, where it cannot be meant."""
    if not reference["lacking"]:
        return []
    numbers, instead = (
        ", ".join(f"({n})" for n in reference[key]) for key in ("refers_to", "instead")
    )
    statement = (
        f"{', '.join(reference['quantities'])} are said to come from {numbers}, which do not give"
    )
    return [
        "### Reference that cannot be meant",
        "",
        f"{statement} {', '.join(reference['lacking'])}; {instead} do.",
        "",
    ]


def _row(record: Record) -> list[str]:
    cells = record["claims"], record["legibility"], describe_verdict(record)
    return [f"({record['equation']})", *cells, describe_basis(record)]


def describe_verdict(record: Record) -> str:
    """Return the verdict as it is shown: what is neglected or approximate is called so."""
    return record["verdict"] if record["grade"] in ("", AT_FAULT) else record["grade"]


def describe_basis(record: Record) -> str:
    """Describe the basis of a verdict: a reading, a single character, completed pieces, the domain
    of use.
    """
    parts = [
        "" if record["robust"] else "the reading",
        "one character" if record["fragile"] else "",
    ]
    parts.append("the domain of use" if record["domain"] else "")
    parts.append("pieces completed" if record["rebuilt"] else "")
    return ", ".join(part for part in parts if part)


def _causes(records: Sequence[Record]) -> list[str]:
    """Describe the numbers of findings and of causes, and list each cause with its equations."""
    paper_causes = group_causes(records)
    if not paper_causes:
        return []
    faulty = sum(1 for record in records if record["grade"] == AT_FAULT)
    rows = []
    for cause in paper_causes:
        numbers = (equation.partition(": ")[2] for equation in cause["equations"])
        rows.append((cause["cause"], ", ".join(f"({number})" for number in numbers)))
    equations = "1 equation is" if faulty == 1 else f"{faulty} equations are"
    reasons = "1 cause" if len(paper_causes) == 1 else f"{len(paper_causes)} causes"
    count = f"{equations} at fault, for {reasons}."
    return [count, "", *_table("cause | equations", rows)]


def _paragraph(record: Record) -> list[str]:
    if record["verdict"] in SILENT and not any(
        record[part] for part in ("vanishing", "depends", "domain")
    ):
        return []
    lines = [f"### ({record['equation']}) {describe_verdict(record)}", ""]
    texts = {
        "As printed": record["transcription"],
        "As read": record["printed"],
        "As derived": record["derived"],
    }
    for label, text in texts.items():
        lines += [f"{label}: `{text}`", ""] if text else []
    lines += [f"Finding: {record['finding']}.", ""]
    lines += [f"Named: {'; '.join(record['reasons'])}.", ""] if record["reasons"] else []
    if record["rebuilt"]:
        lines += [f"Completed: {'; '.join(record['rebuilt'])}.", ""]
    if record["fragile"]:
        lines += ["One character decides: it may be an error of reading.", ""]
    if record["reading"]:
        lines += [f"Reading: {record['reading']}.", ""]
    lines += _depends(record["depends"])
    if record["correction"]:
        lines += [
            "Smallest correction: " + " or ".join(f"`{c}`" for c in record["correction"]) + ".",
            "",
        ]
    lines += _sizes("missing term", record["terms"])
    lines += _sizes("unexplained term", record["unexplained"])
    lines += _together(record)
    lines += _vanishing(record["vanishing"])
    return lines


def _depends(readings: Sequence[Record]) -> list[str]:
    keys = ("reading", "because", "verdict", "finding")
    rows = ([reading[key] for key in keys] for reading in readings)
    return _table("reading | admitted by | verdict | finding", rows)


def _sizes(name: str, terms: Sequence[Record]) -> list[str]:
    rows = (
        (
            f"`{t['term']}`",
            _number(t["max_abs"], 4),
            t["unit"],
            _number(t["share_of_largest"], 3),
        )
        for t in terms
    )
    return _table(f"{name} | largest over the cycle | unit | share of the largest term", rows)


def _together(record: Record) -> Iterator[str]:
    """The sum of several terms that are left, which may be far less than any of them."""
    left = record["difference"]
    if left and len(record["terms"]) + len(record["unexplained"]) > 1 and left["share_of_largest"]:
        unit = "" if left["unit"] == "1" else f" {left['unit']}"
        share = format_share(left["share_of_largest"])
        yield (
            f"Together at most {_number(left['max_abs'], 3)}{unit}, {share} of the largest "
            f"derived term."
        )
        yield ""


def _vanishing(terms: Sequence[Record]) -> list[str]:
    rows = ((f"`{t['term']}`", t["because"], "yes" if t["printed"] else "no") for t in terms)
    return _table("term that vanishes | because | printed", rows)


def _number(value: float | None, digits: int, absent: str = "no real value") -> str:
    return absent if value is None else f"{value:.{digits}g}"


def _list_laws(records: Sequence[Record]) -> list[str]:
    """A section of the page, a table of the laws by paper."""
    if not records:
        return []
    lines = [
        "## Laws of each chain as a whole",
        "",
        "Each printed chain, executed over the reference cycle; a law is",
    ]
    lines += [
        "laid to the smallest set of equations whose repair restores it. A search is exhaustive "
        "if every smaller"
    ]
    lines += [
        "set, and every other of that size, was tried; one by elimination may have missed a "
        "smaller set.",
        "",
    ]
    for paper, reading in {r["paper"]: r["reading"] for r in records if r["reading"]}.items():
        lines += [
            f"{paper} is read under the kindest joint reading: {reading}. Read literally: what "
            f"the generated printed"
        ]
        lines += [
            "model computes, in which each symbol means what the equation that gives it says.",
            "",
        ]
    rows = []
    for record in records:
        sets = [record["caused_by"], *record["or_by"]] if record["caused_by"] else []
        names = (", ".join(f"({number})" for number in chosen) for chosen in sets)
        laid = " or ".join(names) or "kept"
        if record["violation"] is None:
            laid = record["owed"]
        sizes = (
            _number(record[key], LAW_DIGITS, "unknown")
            for key in ("violation", "violation_literal")
        )
        rows.append(
            (record["paper"], record["law"], *sizes, record["unit"], laid, record["search"])
        )
    lines += _table("paper | law | broken by | read literally | unit | laid to | search", rows)
    lines += [
        "What each of these equations does: what its repair alone takes away, what it alone "
        "leaves when all",
        "others are repaired, and its Shapley value, the mean over all orders of repair. These "
        "values add up to",
        "the violation; some may be negative, so that others exceed it.",
        "",
    ]
    for record in records:
        lines += _shares(record)
    return lines


def _shares(law: Record) -> list[str]:
    if not law["shares"]:
        return []
    rows = []
    for share in law["shares"]:
        sizes = (f"{share[key]:.4g}" for key in ("alone", "without", "shapley"))
        rows.append((f"({share['equation']})", *sizes))
    head = f"equation | alone [{law['unit']}] | left | Shapley"
    return [f"**{law['law']}**: {law['owed']}", "", *_table(head, rows)]


FILES = ("audit.json", "audit_mathml.json", "verdicts.json", "AUDIT.md")
"""What is written: the findings, their formulas typeset, what repeats them, and the findings to
read.
"""
Place = tuple[str, str]
"""Name and file of a module, to load it again in another process."""


def find_cases(modules: Iterable[ModuleType]) -> dict[str, Case]:
    """Module name -> the case that it states (``CASE``), in the order in which papers are shown;
    others state none.

    Raises ValueError where two papers have one name.
    """
    cases_by_module = {
        module.__name__: case
        for module in modules
        if isinstance(case := getattr(module, "CASE", None), Case)
    }
    names = [case.paper.name for case in cases_by_module.values()]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise ValueError(f"two papers have one name: {', '.join(twice)}")
    return dict(sorted(cases_by_module.items(), key=lambda item: item[1].paper.rank))


def judge_cases(modules: Iterable[ModuleType], committed: Path | None = None) -> dict[str, str]:
    """File name -> content: what the audit found of every equation of the modules' papers, and of
    the laws.

    What a committed audit.json says of an equation is used again if it was made from the same.
    Raises ClaimError where an equation claims what its subject does not derive.
    """
    committed_records, committed_typeset, committed_evidence = (
        _read(committed.with_name(name)) if committed else {} for name in FILES[:3]
    )
    modules_ = list(modules)
    reusable = index_records(
        committed_records.get("equations", []),
        committed_typeset,
        committed_evidence.get("records", []),
    )
    records, laws = judge_modules(modules_, reusable, committed_records.get("laws", []))
    papers = {case.paper.name: _about(case) for case in find_cases(modules_).values()}
    titles = {name: about["title"] for name, about in papers.items()}
    cross = [
        reference for case in find_cases(modules_).values() for reference in judge_references(case)
    ]
    rows = [
        row
        for c in find_cases(modules_).values()
        if c.source is not None
        for row in c.source.list_rows()
    ]
    from . import check_verdicts  # needs python-flint, and says what it checks

    describe: Any = check_verdicts.describe_verdict
    evidence = [
        record[EVIDENCE] | {"statement": describe(record[EVIDENCE])}
        for record in records
        if EVIDENCE in record
    ]
    texts = (
        format_records(records, laws, cross, papers, rows),
        format_typeset(records),
        format_evidence(evidence, find_cases(modules_).values()),
        as_page(records, titles, laws, cross),
    )
    return dict(zip(FILES, texts, strict=True))


def _about(case: Case) -> dict[str, str]:
    """Title of a paper, and the name of the model that computes its numbers, if there is one."""
    model = case.subject.model()
    return {"title": case.paper.reference, "model": "" if model is None else model.name}


def _read(file: Path) -> dict[str, Any]:
    content: dict[str, Any] = json.loads(file.read_text(encoding="utf-8")) if file.is_file() else {}
    return content


def judge_modules(
    modules: Sequence[ModuleType],
    known_records: Mapping[tuple[str, str], Record],
    known_laws: Sequence[Record],
) -> tuple[list[Record], list[Record]]:
    """Records of all equations and laws: known ones that still hold, and the rest, judged in
    parallel.

    A paper is judged again as a whole. A chain is checked by its laws together with its equations,
    which their judgement decides: those come first.
    """
    cases = find_cases(modules)
    for case in cases.values():
        # what has no values at all is an error of the subject, not of an equation
        _ = case.points, case.cycle
    keys = {m: key.equations_key(case) for m, case in cases.items()}
    places = [(m, str(sys.modules[m].__file__)) for m in cases]
    records: dict[str, dict[str, Record]] = {}
    laws: dict[str, list[Record]] = {}
    tasks: dict[str, list[Future[list[Record]]]] = {}
    trials: dict[str, Future[list[Record]]] = {}
    with ExitStack() as open_pools:

        @cache
        def pool() -> Executor:
            return open_pools.enter_context(
                ProcessPoolExecutor(initializer=load_modules, initargs=(places,))
            )

        for m in sorted(cases, key=lambda m: cases[m].chains is None):
            case, name = cases[m], cases[m].paper.name
            equations = case.paper.equations
            old = {n: known_records.get((name, n), {}) for n in equations}
            if all(is_reusable(record, keys[m]) for record in old.values()):
                records[m] = old
            else:
                groups = dict.fromkeys(map(case.linked, equations))
                tasks[m] = [pool().submit(_equations, m, group, keys[m]) for group in groups]
            if case.chains is None:
                continue
            records[m] = _results(tasks.pop(m)) if m in tasks else records[m]
            answers = {n: str(records[m][n]["answer"]) for n in case.executed}
            law_key = key.laws_key(case, case.select_choices(answers))
            laws[m] = [r for r in known_laws if r["paper"] == name]
            if not (laws[m] and all(is_reusable(r, law_key) for r in laws[m])):
                trials[m] = pool().submit(_laws, m, answers, law_key)
        records |= {m: _results(started) for m, started in tasks.items()}
        laws |= {m: trial.result() for m, trial in trials.items()}
    judged = [records[m][n] for m, case in cases.items() for n in case.paper.equations]
    return judged, [_with_sentence(r, judged) for of_paper in laws.values() for r in of_paper]


def _results(tasks: Iterable[Future[list[Record]]]) -> dict[str, Record]:
    """Records by the number of their equation."""
    return {str(r["equation"]): r for task in tasks for r in task.result()}


def _with_sentence(law: Record, equations: Iterable[Record]) -> Record:
    """The record of a law with the sentence that says what it is owed to most; one not judged has
    its reason there.
    """
    if law["search"] == UNJUDGED:
        return law
    return law | {
        "owed": describe_law_cause(
            law, {r["equation"]: r for r in equations if r["paper"] == law["paper"]}
        )
    }


def load_modules(places: Iterable[Place]) -> None:
    """Load modules that are not loaded yet, as in a process that is not forked: each from its
    file.
    """
    for name, file in places:
        spec = spec_from_file_location(name, file)
        if name not in sys.modules and spec and spec.loader:
            sys.modules[name] = module_from_spec(spec)
            spec.loader.exec_module(sys.modules[name])


def _equations(module: str, numbers: Sequence[str], its_key: str) -> list[Record]:
    return record_equations(_case(module), numbers, its_key)


def _laws(module: str, answers: Mapping[str, str], its_key: str) -> list[Record]:
    """The findings on the chains of a case as a whole, as they are read; none if its subject states
    no laws.

    Where the chains cannot be executed at all there is one record, `not judged`, with the reason.
    """
    case = _case(module)
    chosen = case.select_choices(answers)
    meanings = dict.fromkeys(
        answer.meaning for choice in chosen.values() for answer in choice.answers if answer.rereads
    )
    try:
        dynamics = case.subject.dynamics()
        if case.chains is None or dynamics is None:
            return []
        literal = ChainLaws(*case.chains, dynamics)
        records = judge_laws(
            case.paper.name, ChainLaws(*case.read_chains(chosen), dynamics) if meanings else literal
        )
        sizes = [attempted_violation(literal, law) for law in dynamics.laws]
    except Exception as error:  # equations are judged one by one, whatever becomes of their chain
        records, sizes = (
            [record_untried_law(case.paper.name, "laws of the chain as a whole", "", error)],
            [None],
        )
    about_reading = {"reading": "; ".join(meanings), "key": its_key}
    return [
        law | {"violation_literal": size} | about_reading
        for law, size in zip(records, sizes, strict=True)
    ]


def _case(module: str) -> Case:
    case: Case = sys.modules[module].CASE
    return case
