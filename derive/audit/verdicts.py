"""The audit of papers, theirs or a user's: what was found of every equation and every law, as data and as a page."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
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
from .trial import Trial, findings, untried

FILES = ("audit.json", "audit_mathml.json", "AUDIT.md")
"""What is written: the findings, their formulas typeset, and the findings to read."""
Place = tuple[str, str]
"""Name and file of a module, to load it again in another process."""
Numbered = tuple[str, str]
"""Name of a module and number of an equation of its paper."""


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
    """Records of all equations and laws: known ones that still hold, and the rest, judged in parallel."""
    found = cases(modules)
    for case in found.values():
        _ = case.points, case.cycle  # what has no values at all is an error of the subject, not of an equation
    keys: dict[Numbered, str] = {}
    records: dict[Numbered, record.Record | None] = {}
    for m, n in [(m, n) for m, case in found.items() for n in case.paper.equations]:
        try:
            keys[m, n] = key.of_equation(found[m], n)
            records[m, n] = known.get((found[m].paper.name, n))
        except ClaimError:
            raise
        except Exception as error:  # without a key there is no comparison to judge: one line, not the end
            keys[m, n], records[m, n] = "", record.not_judged(found[m], n, "", error)
    law_keys = {m: key.of_laws(case) for m, case in found.items() if case.chains}
    laws = {m: [r for r in known_laws if r["paper"] == found[m].paper.name] for m in law_keys}
    open_equations = [one for one, old in records.items() if not record.reusable(old, keys[one])]
    open_laws = [m for m, old in laws.items() if not (old and all(record.reusable(r, law_keys[m]) for r in old))]
    if open_equations or open_laws:
        places = [(m, str(sys.modules[m].__file__)) for m in found]
        with ProcessPoolExecutor(initializer=load, initargs=(places,)) as pool:
            trials = {m: pool.submit(_laws, m, law_keys[m]) for m in open_laws}
            new = pool.map(_equation, open_equations, [keys[one] for one in open_equations])
            records |= zip(open_equations, new, strict=True)
            laws |= {m: trial.result() for m, trial in trials.items()}
    judged_equations = [r for r in records.values() if r is not None]
    return judged_equations, [_with_sentence(r, judged_equations) for of_paper in laws.values() for r in of_paper]


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


def _equation(one: Numbered, its_key: str) -> record.Record:
    module, number = one
    return record.equation(_case(module), number, its_key)


def _laws(module: str, its_key: str) -> list[record.Record]:
    """The findings on the chains of a case as a whole; none if its subject states no laws.

    Where the chains cannot be executed at all there is one record, `not judged`, with the reason.
    """
    case = _case(module)
    try:
        dynamics = case.subject.dynamics()
        if case.chains is None or dynamics is None:
            return []
        found = findings(case.paper.name, Trial(*case.chains, dynamics))
    except Exception as error:  # equations are judged one by one, whatever becomes of their chain
        found = [untried(case.paper.name, "laws of the chain as a whole", "", error)]
    return [law | {"key": its_key} for law in found]


def _case(module: str) -> Case:
    case: Case = sys.modules[module].CASE
    return case
