"""The page of errors that the audit found in public texts, from the corpus of its benchmark."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from derive.audit.texts.benchmark import CorpusText, read_corpus

CORPUS = Path(__file__).parents[2] / "tests" / "papers" / "corpus"
HEAD = """\
# Errors in public texts

Errors in displayed equations of public texts, as the corpus of `planter audit --benchmark` records them
([how](../text.md)). Each was verified by a computation apart from the audit. A row is named by its label or its line;
below stands the row as it should be. Repository, commit and path of each text are given, so that an entry can be
reported to its authors.
"""


def describe_text(text: CorpusText) -> Iterator[str]:
    """Yield the lines on a text: where it is, and its errors."""
    table = text.table
    yield f"\n## {table['title']}\n"
    place = f"`{table['repository']}`, commit `{table['commit'][:12]}`, `{table['path']}`"
    yield f"{', '.join(table['authors'])}. {place}.\n"
    for entry in table["errata"]:
        yield (
            f"**{entry['row']}.** {entry['what']} {entry['verified']} Source: {entry['source']}.\n"
        )
        yield f"```latex\n{entry['corrected'].strip()}\n```\n"


def page() -> str:
    """Return the page."""
    texts = [text for text in read_corpus(CORPUS) if text.table.get("errata")]
    return HEAD + "\n".join(line for text in texts for line in describe_text(text))
