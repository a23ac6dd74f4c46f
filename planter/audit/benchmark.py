"""`planter audit --benchmark`: how well the audit finds errors in texts of a corpus, beside other
checkers.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from planter.audit.results import AuditBenchmark, CheckerScore
from planter.errors import InputError
from planter.files.derivation import BENCHMARK, score_corpus
from planter.report.html import Block, Cell, Section, Table, Text
from planter.report.presentation import ResultPresentation
from planter.text_files import read_json
from planter.version import __version__

CORPUS = Path("tests/papers/corpus")
"""The corpus of this project, in a clone of it."""
OWN = "planter"
CLAIMS = "claims.jsonl"
"""File with the claims that another checker is asked about, one JSON object a line."""
MOST_BYTES = 50_000_000


def run_benchmark(
    corpus: Path, slips: int, seed: int, answers: Path | None
) -> tuple[AuditBenchmark, list[Any]]:
    """Return the scores on a corpus, and the claims that were judged.

    Raises InputError for files that are wrong.
    """
    if not corpus.is_dir():
        allowed = "give the folder of a corpus; that of this project is in a clone of it"
        raise InputError(f"{corpus}: there is no such folder: {allowed}")
    with TemporaryDirectory() as folder:
        score_corpus(corpus, Path(folder), slips, seed, answers)
        content = read_json(Path(folder, BENCHMARK), MOST_BYTES, MOST_BYTES)
    return AuditBenchmark.read(
        {key: value for key, value in content.items() if key != "claims"}
    ), content["claims"]


def present_benchmark(result: AuditBenchmark, claims: Sequence[Any]) -> ResultPresentation:
    """Return the presentation of a benchmark."""
    score = result.checkers[OWN].all
    return ResultPresentation(
        title="Benchmark of formula audits",
        conclusion=f"{score.detected} of {score.slips} slips are detected, {score.repaired} "
        f"repaired exactly; "
        f"{score.false_alarms} of {score.sound} sound equations raise a false alarm; "
        f"{score.errata_found} of {score.errata} known errors are found.",
        record=result,
        sections=list(_list_sections(result)),
        texts=lambda: {CLAIMS: "".join(json.dumps(claim) + "\n" for claim in claims)},
        provenance={"planter": __version__},
    )


COLUMNS = ("slips", "detected", "repaired", "sound", "false alarms", "errata", "found", "refused")


def _list_sections(result: AuditBenchmark) -> Iterator[Section]:
    rows: list[Sequence[Cell]] = [
        (name, part, *_list_counts(score))
        for name, scores in result.checkers.items()
        for part, score in (("all texts", scores.all), ("held out", scores.held_out))
    ]
    yield Section("Checkers", [Table(("checker", "texts", *COLUMNS), rows)])
    compared = {name: scores.classes for name, scores in result.checkers.items() if name != OWN}
    by_class: list[Sequence[Cell]] = [
        [
            slip,
            score.slips,
            score.detected,
            score.repaired,
            *(classes[slip].detected for classes in compared.values()),
        ]
        for slip, score in result.checkers[OWN].classes.items()
    ]
    columns = (
        "class",
        "slips",
        "detected",
        "repaired",
        *(f"detected by {name}" for name in compared),
    )
    yield Section("Slips by class", [Table(columns, by_class)])
    texts: list[Block] = [
        Table(
            ("text", "licence", "held out", "rows", "read", "sound", "errata", "s"),
            [
                (
                    text.name,
                    text.licence,
                    text.is_held_out,
                    text.rows,
                    text.read_rows,
                    text.sound,
                    text.errata,
                    text.seconds,
                )
                for text in result.texts
            ],
        )
    ]
    if result.absent:
        texts.append(Text(f"Not fetched: {', '.join(result.absent)}."))
    yield Section("Texts", texts)


def _list_counts(score: CheckerScore) -> tuple[int, ...]:
    return (
        score.slips,
        score.detected,
        score.repaired,
        score.sound,
        score.false_alarms,
        score.errata,
        score.errata_found,
        score.refused,
    )
