"""A paper of one's own on trial: its file is derived and judged, its printed numbers are computed anew."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from planter import rooms
from planter.audit import numbers, question, verdicts
from planter.errors import InputError
from planter.files import paths
from planter.files.derivation import GENERATED, derived
from planter.files.text import read_bytes, read_json
from planter.report import files
from planter.report.folder import NAME as LIST

VERDICTS, TYPESET = "audit.json", "audit_mathml.json"
LARGEST = 100_000_000
"""Bytes of verdicts, and values in them: `derive` wrote them just before."""


@dataclass(frozen=True)
class Tried:
    """What was found, what is typeset of it by paper and equation, and the folder where the verdicts were written."""

    result: dict[str, Any]
    typeset: Mapping[str, Any]
    folder: Path


def tried(source: Path, printed: Path | None = None) -> Tried:
    """The papers of a Python file or folder, judged; the numbers of one of them from a file.

    Verdicts and functions are written to ``generated`` beside it. Raises InputError for what is wrong in either file.
    """
    listed = None if printed is None else question.read(printed)
    folder = (source if source.is_dir() else source.parent) / GENERATED
    with TemporaryDirectory() as place:
        derived(source, Path(place))
        if not Path(place, VERDICTS).is_file():
            raise InputError(f"{source}: it puts no paper on trial: it must offer CASE = trial(mechanism, paper)")
        derivations = {path.relative_to(place).as_posix(): path for path in Path(place).rglob("*") if path.is_file()}
        files.write_all(folder, {name: read_bytes(path, LARGEST) for name, path in derivations.items()
                                 if path.name != LIST})  # fmt: skip
    content, typeset = (read_json(folder / name, LARGEST, LARGEST) for name in (VERDICTS, TYPESET))
    papers: dict[str, dict[str, str]] = content["papers"]
    judged = [] if listed is None or printed is None else _judged(listed, printed, papers, folder)
    titles = {name: about["title"] for name, about in papers.items()}
    return Tried(verdicts.gathered(content, judged, titles), typeset, folder)


def _judged(
    listed: question.NumbersFile, source: Path, papers: Mapping[str, Mapping[str, str]], folder: Path
) -> list[dict[str, Any]]:
    name = meant(listed, source, papers)
    model = papers[name]["model"]
    if not model:
        raise InputError(f"{source}: {name} is tried against nothing that computes numbers: a mechanism does")
    for room in rooms.brought("printed"):
        numbers.load(room)
    found = list(question.rows(listed, source, name, folder / f"{model}.toml"))
    table = {"disclosed": {name: listed.disclosed}, "assumed": {name: listed.assumed}, "number": found}
    return numbers.judged(name, table)


def meant(listed: question.NumbersFile, source: Path, papers: Mapping[str, Any]) -> str:
    """Which paper the numbers are of: it need not be said where there is one alone."""
    if listed.paper is None and len(papers) == 1:
        return next(iter(papers))
    if listed.paper in papers:
        return str(listed.paper)
    if listed.paper is None:
        raise InputError(f"{source}: paper is missing: it must be one of {', '.join(papers)}")
    near = paths.close(listed.paper, papers)
    hint = f"did you mean {near[0]}?" if near else f"it must be one of {', '.join(papers)}"
    raise InputError(f"{source}: paper = {listed.paper!r} is not allowed: {hint}")
