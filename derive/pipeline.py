"""Everything that `generated/` holds, as texts by path: code (`derive`), verdicts (`audit`)."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from pathlib import Path

from .audit import key, page, record
from .audit.subject import Subject
from .audit.trial import Trial, findings
from .gearing.meshing import FAMILIES
from .generation import code
from .papers import shi2021, sun2019, wang2017, yu2023
from .systems.clutch import claims as clutch
from .systems.mapping import claims as mapping
from .systems.pickup import claims as pickup
from .systems.planting import cycle
from .systems.planting import laws as planting_laws
from .systems.planting import subject as planting_trial

TRIALS = ((wang2017, planting_trial), (shi2021, clutch), (yu2023, pickup), (sun2019, mapping))
"""Each paper with the system that derives what it claims."""


def verdicts(committed: Path | None = None) -> dict[str, str]:
    """Path inside `generated/` -> content: what the audit found of every equation and of the laws.

    What a committed audit.json says of an equation is kept if it was made from the same.
    """
    known = json.loads(committed.read_text(encoding="utf-8")) if committed and committed.is_file() else {}
    records, laws = judged(record.keyed(known.get("equations", [])), known.get("laws", []))
    references = {paper.PAPER.name: paper.PAPER.reference for paper, _ in TRIALS}
    return {"audit.json": record.as_json(records, laws), "AUDIT.md": page.as_page(records, references, laws)}


def judged(
    known: Mapping[tuple[str, str], record.Record], known_laws: Sequence[record.Record]
) -> tuple[list[record.Record], list[record.Record]]:
    """Records of all equations and laws: known ones that still hold, and the rest, judged in parallel."""
    keys = {(i, n): key.of_equation(subject(i), n) for i in range(len(TRIALS)) for n in subject(i).paper.equations}
    old = {(i, n): known.get((subject(i).paper.name, n)) for i, n in keys}
    open_cases = [case for case in keys if not record.reusable(old[case], keys[case])]
    laws_key = _laws_key()
    laws_hold = bool(known_laws) and all(record.reusable(law, laws_key) for law in known_laws)
    new: dict[tuple[int, str], record.Record] = {}
    found = list(known_laws)
    if open_cases or not laws_hold:
        with ProcessPoolExecutor() as pool:
            trial = None if laws_hold else pool.submit(_laws, laws_key)
            new = dict(zip(open_cases, pool.map(_equation, open_cases, [keys[c] for c in open_cases]), strict=True))
            found = trial.result() if trial else found
    return [new.get(case) or _known(old[case]) for case in keys], found


def _known(found: record.Record | None) -> record.Record:
    if found is None:
        raise ValueError("a case is neither judged nor known")
    return found


PARTS: dict[str, Callable[[Path | None], dict[str, str]]] = {"code": lambda _: code(), "audit": verdicts}
VERDICTS = frozenset({"audit.json", "AUDIT.md"})


@cache
def subject(index: int) -> Subject:
    """The subject of a trial."""
    return Subject.of(*TRIALS[index])


def _equation(case: tuple[int, str], its_key: str) -> record.Record:
    index, number = case
    return record.equation(subject(index), number, its_key)


def _laws(its_key: str) -> list[record.Record]:
    trial = Trial(wang2017.SIDE, wang2017.FRAME, planting_laws.machine())
    return [found | {"key": its_key} for found in findings(wang2017.PAPER.name, trial)]


def _laws_key() -> str:
    chains = wang2017.SIDE, wang2017.FRAME
    found = sorted({type(family).__module__ for family in FAMILIES.values()})
    data = cycle.MACHINE.read_text(encoding="utf-8")
    return key.of_chain([planting_laws.__name__, *found], chains, data)
