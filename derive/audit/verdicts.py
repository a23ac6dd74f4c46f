"""The audit of papers, theirs or a user's: what was found of every equation and every law, as data and as a page."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from contextlib import ExitStack
from functools import cache
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType
from typing import Any

from ..equations import ClaimError
from . import key, page, record
from .case import Case
from .causes import told
from .judgement import UNJUDGED
from .references import references
from .trial import Trial, attempted_violation, findings, record_untried_law

FILES = ("audit.json", "audit_mathml.json", "AUDIT.md")
"""What is written: the findings, their formulas typeset, and the findings to read."""
Place = tuple[str, str]
"""Name and file of a module, to load it again in another process."""


def cases(modules: Iterable[ModuleType]) -> dict[str, Case]:
    """Module name -> the case that it states (``CASE``), in the order in which papers are shown; others state none.

    Raises ValueError where two papers have one name.
    """
    found = {module.__name__: case for module in modules if isinstance(case := getattr(module, "CASE", None), Case)}
    names = [case.paper.name for case in found.values()]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise ValueError(f"two papers have one name: {', '.join(twice)}")
    return dict(sorted(found.items(), key=lambda item: item[1].paper.rank))


def verdicts(modules: Iterable[ModuleType], committed: Path | None = None) -> dict[str, str]:
    """File name -> content: what the audit found of every equation of the modules' papers, and of the laws.

    What a committed audit.json says of an equation is kept if it was made from the same. Raises ClaimError where an
    equation claims what its subject does not derive.
    """
    known, shown = (_read(committed.with_name(name)) if committed else {} for name in FILES[:2])
    own = list(modules)
    records, laws = judged(own, record.keyed(known.get("equations", []), shown), known.get("laws", []))
    papers = {case.paper.name: _about(case) for case in cases(own).values()}
    titles = {name: about["title"] for name, about in papers.items()}
    cross = [found for case in cases(own).values() for found in references(case)]
    texts = (
        record.as_json(records, laws, cross, papers),
        record.typeset(records),
        page.as_page(records, titles, laws, cross),
    )
    return dict(zip(FILES, texts, strict=True))


def _about(case: Case) -> dict[str, str]:
    """Title of a paper, and the name of the model that computes its numbers anew, if there is one."""
    model = case.subject.model()
    return {"title": case.paper.reference, "model": "" if model is None else model.name}


def _read(file: Path) -> dict[str, Any]:
    content: dict[str, Any] = json.loads(file.read_text(encoding="utf-8")) if file.is_file() else {}
    return content


def judged(
    modules: Sequence[ModuleType],
    known: Mapping[tuple[str, str], record.Record],
    known_laws: Sequence[record.Record],
) -> tuple[list[record.Record], list[record.Record]]:
    """Records of all equations and laws: known ones that still hold, and the rest, judged in parallel.

    A chain is held to its laws as its equations are read, which their judgement decides: those come first.
    """
    found = cases(modules)
    for case in found.values():
        _ = case.points, case.cycle  # what has no values at all is an error of the subject, not of an equation
    keys, records = {}, {}
    for m, case in found.items():
        keys[m], failed = _keys(case)
        records[m] = {n: failed.get(n) or known.get((case.paper.name, n)) for n in keys[m]}
    laws = {m: [r for r in known_laws if r["paper"] == case.paper.name] for m, case in found.items() if case.chains}
    places = [(m, str(sys.modules[m].__file__)) for m in found]
    with ExitStack() as open_pools:

        @cache
        def pool() -> Executor:
            return open_pools.enter_context(ProcessPoolExecutor(initializer=load, initargs=(places,)))

        trials: dict[str, Future[list[record.Record]]] = {}
        tasks = {m: _submitted(pool, m, found[m], keys[m], records[m]) for m in laws}
        for m, case in found.items():
            if m in laws:
                records[m] |= _results(tasks[m])
                answers = {n: str(r["answer"]) for n in case.executed if (r := records[m][n])}
                law_key = key.of_laws(case, case.choices_by(answers))
                if not (laws[m] and all(record.reusable(r, law_key) for r in laws[m])):
                    trials[m] = pool().submit(_laws, m, answers, law_key)
        tasks |= {m: _submitted(pool, m, found[m], keys[m], records[m]) for m in found if m not in laws}
        for m, started in tasks.items():
            records[m] |= _results(started)
        laws |= {m: trial.result() for m, trial in trials.items()}
    judged_equations = [r for of_paper in records.values() for r in of_paper.values() if r is not None]
    return judged_equations, [_with_sentence(r, judged_equations) for of_paper in laws.values() for r in of_paper]


def _keys(case: Case) -> tuple[dict[str, str], dict[str, record.Record]]:
    """Keys of all equations of a paper, and records of those that cannot be compared: their key is empty."""
    alone, failed = dict[str, str](), dict[str, record.Record]()
    for number in case.paper.equations:
        try:
            alone[number] = key.of_sides(case, number)
        except ClaimError:
            raise
        except Exception as error:  # without a key there is no comparison to judge: one line, not the end
            alone[number], failed[number] = str(error), record.record_unjudged(case, number, "", error)
    return {n: "" if n in failed else key.of_linked(n, [alone[o] for o in case.linked(n)]) for n in alone}, failed


def _submitted(
    pool: Callable[[], Executor],
    module: str,
    case: Case,
    keys: Mapping[str, str],
    old: Mapping[str, record.Record | None],
) -> list[Future[list[record.Record]]]:
    """Judgement of every equation without a record that still holds, those together that share questions."""
    still_open = [n for n in keys if not record.reusable(old[n], keys[n])]
    together = dict.fromkeys(case.linked(n) for n in still_open)
    return [pool().submit(_equations, module, {n: keys[n] for n in numbers if n in still_open}) for numbers in together]


def _results(tasks: Iterable[Future[list[record.Record]]]) -> dict[str, record.Record]:
    """Records by the number of their equation."""
    return {str(r["equation"]): r for task in tasks for r in task.result()}


def _with_sentence(law: record.Record, equations: Iterable[record.Record]) -> record.Record:
    """The record of a law with the sentence that says what it is owed to most; one not judged has its reason there."""
    if law["search"] == UNJUDGED:
        return law
    return law | {"owed": told(law, {r["equation"]: r for r in equations if r["paper"] == law["paper"]})}


def load(places: Iterable[Place]) -> None:
    """Load modules that are not loaded yet, as in a process that is not forked: each from its file."""
    for name, file in places:
        spec = spec_from_file_location(name, file)
        if name not in sys.modules and spec and spec.loader:
            sys.modules[name] = module_from_spec(spec)
            spec.loader.exec_module(sys.modules[name])


def _equations(module: str, keys: Mapping[str, str]) -> list[record.Record]:
    return record.equations(_case(module), keys)


def _laws(module: str, answers: Mapping[str, str], its_key: str) -> list[record.Record]:
    """The findings on the chains of a case as a whole, as they are read; none if its subject states no laws.

    Where the chains cannot be executed at all there is one record, `not judged`, with the reason.
    """
    case = _case(module)
    chosen = case.choices_by(answers)
    told = dict.fromkeys(answer.meaning for choice in chosen.values() for answer in choice.answers if answer.rereads)
    try:
        dynamics = case.subject.dynamics()
        if case.chains is None or dynamics is None:
            return []
        literal = Trial(*case.chains, dynamics)
        found = findings(case.paper.name, Trial(*case.read_chains(chosen), dynamics) if told else literal)
        sizes = [attempted_violation(literal, law) for law in dynamics.laws]
    except Exception as error:  # equations are judged one by one, whatever becomes of their chain
        found, sizes = [record_untried_law(case.paper.name, "laws of the chain as a whole", "", error)], [None]
    as_told = {"reading": "; ".join(told), "key": its_key}
    return [law | {"violation_literal": size} | as_told for law, size in zip(found, sizes, strict=True)]


def _case(module: str) -> Case:
    case: Case = sys.modules[module].CASE
    return case
