"""Audit of a user's paper: its Python file is derived and judged, its printed numbers are recomputed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from planter import plugins
from planter.audit import numbers, question, verdicts
from planter.errors import InputError
from planter.files import paths
from planter.files.derivation import GENERATED, derived
from planter.files.text import read_bytes, read_json
from planter.report import files
from planter.report.folder import NAME as LIST

VERDICTS, TYPESET = "audit.json", "audit_mathml.json"
MAX_SIZE = 100_000_000
"""Largest number of bytes and values of the verdicts, which `derive` has just written."""


@dataclass(frozen=True)
class PaperAudit:
    """The result, its typeset formulas by paper and equation, and the folder of the written verdicts."""

    result: dict[str, Any]
    typeset: Mapping[str, Any]
    folder: Path


def audit_user_paper(source: Path, printed: Path | None = None) -> PaperAudit:
    """Judge the papers of a Python file or folder, with the numbers of one of them from a file.

    Verdicts and functions are written to `generated` next to it. Raises InputError for an error in either file.
    """
    numbers_file = None if printed is None else question.read_numbers_file(printed)
    folder = (source if source.is_dir() else source.parent) / GENERATED
    with TemporaryDirectory() as folder_name:
        derived(source, Path(folder_name))
        if not Path(folder_name, VERDICTS).is_file():
            raise InputError(f"{source}: the file states no paper: define CASE = trial(mechanism, paper)")
        derivations = {
            path.relative_to(folder_name).as_posix(): path for path in Path(folder_name).rglob("*") if path.is_file()
        }
        files.write_all(folder, {name: read_bytes(path, MAX_SIZE) for name, path in derivations.items()
                                 if path.name != LIST})  # fmt: skip
    content, typeset = (read_json(folder / name, MAX_SIZE, MAX_SIZE) for name in (VERDICTS, TYPESET))
    papers: dict[str, dict[str, str]] = content["papers"]
    number_verdicts = (
        [] if numbers_file is None or printed is None else _judge_file(numbers_file, printed, papers, folder)
    )
    titles = {name: about["title"] for name, about in papers.items()}
    return PaperAudit(verdicts.collect_verdicts(content, number_verdicts, titles), typeset, folder)


def _judge_file(
    numbers_file: question.NumbersFile, source: Path, papers: Mapping[str, Mapping[str, str]], folder: Path
) -> list[dict[str, Any]]:
    name = find_paper(numbers_file, source, papers)
    model = papers[name]["model"]
    if not model:
        raise InputError(f"{source}: {name} has no mechanism, which is needed to compute numbers")
    for room in plugins.load_modules("printed"):
        numbers.load_formulas(room)
    rows = list(question.list_rows(numbers_file, source, name, folder / f"{model}.toml"))
    table = {"disclosed": {name: numbers_file.disclosed}, "assumed": {name: numbers_file.assumed}, "number": rows}
    return numbers.judge_numbers(name, table)


def find_paper(numbers_file: question.NumbersFile, source: Path, papers: Mapping[str, Any]) -> str:
    """Return the paper of the numbers, which may be left out if there is only one."""
    if numbers_file.paper is None and len(papers) == 1:
        return next(iter(papers))
    if numbers_file.paper in papers:
        return str(numbers_file.paper)
    if numbers_file.paper is None:
        raise InputError(f"{source}: paper is missing: it must be one of {', '.join(papers)}")
    close = paths.close(numbers_file.paper, papers)
    hint = f"did you mean {close[0]}?" if close else f"it must be one of {', '.join(papers)}"
    raise InputError(f"{source}: paper = {numbers_file.paper!r} is not allowed: {hint}")
