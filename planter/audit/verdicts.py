"""`planter audit`: the committed verdicts on printed equations and laws, and printed numbers computed anew.

Equations and laws were judged when the code was generated and are read; numbers are computed when asked for.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from difflib import get_close_matches
from typing import Any

from planter.audit import claims, consequences, numbers
from planter.errors import ComputationError, InputError
from planter.kernels import generated

Entry = Mapping[str, Any]


def audit(paper: str | None = None) -> dict[str, Any]:
    """Verdicts on all papers, or on one of them, as the interface gives them.

    Raises InputError for a paper that is not one of those audited.
    """
    wanted = list(numbers.papers()) if paper is None else [checked(paper)]
    found = gathered(committed(), numbers.judged(paper), {name: numbers.papers()[name] for name in wanted})
    drawn = consequences.drawn(paper, numbers.data(), found)
    return found | {"claims": _of(claims.judged(paper), wanted), "consequences": drawn}


def gathered(verdicts: Entry, judged: Sequence[Entry], titles: Mapping[str, str]) -> dict[str, Any]:
    """The verdicts on some papers with those on their numbers, without statements of their texts."""
    parts = ("equations", "laws", "causes", "references")
    equations, laws, causes, references = (_of(verdicts.get(part, ()), list(titles)) for part in parts)
    mine = _of(judged, list(titles))
    return {
        "equations": equations,
        "laws": laws,
        "numbers": mine,
        "causes": _of([*causes, *numbers.causes(mine)], list(titles)),
        "references": references,
        "claims": [],
        "consequences": [],
        "summary": {
            name: {
                "title": title,
                "equations": counts(_of(equations, [name])),
                "at_fault": sum(1 for e in _of(equations, [name]) if e["verdict"] in consequences.FAULTY),
                "causes": len(_of(causes, [name])) + len(numbers.causes(_of(mine, [name]))),
                "laws_violated": sum(1 for law in _of(laws, [name]) if law["caused_by"]),
                "numbers": counts(_of(mine, [name])),
            }
            for name, title in titles.items()
        },
    }


def checked(paper: str) -> str:
    """The short name of a paper, if there is such a one."""
    known = list(numbers.papers())
    if paper in known:
        return paper
    close = get_close_matches(paper.lower(), known, 1)
    hint = f" (did you mean {close[0]}?)" if close else ""
    raise InputError(f"PAPER = {paper!r} is not allowed: it must be one of {', '.join(known)}{hint}")


def committed() -> dict[str, Any]:
    """The verdicts that were written when the code was generated."""
    try:
        return generated.sidecar("audit")
    except FileNotFoundError:
        raise ComputationError("there are no verdicts on equations here: they are written by `make audit`") from None


def counts(entries: Iterable[Entry]) -> dict[str, int]:
    """How often each verdict was given, by name."""
    return dict(sorted(Counter(entry["verdict"] for entry in entries).items()))


def _of(entries: Iterable[Entry], papers: Sequence[str]) -> list[dict[str, Any]]:
    return [dict(entry) for name in papers for entry in entries if entry["paper"] == name]
