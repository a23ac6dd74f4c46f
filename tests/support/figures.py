"""Figures of the pages, taken from what commands print: `python -m tests.support.figures [NAME...]`
renews them.

`docs/figures.toml` lists sentences of pages with fields such as `{exact.refined.range_N:.2f}`: the
result of a command, then keys of its JSON; an entry of a list is named by one of its values. The
values stand in `docs/figures.json`. Without a name the script runs the quick commands alone, with
names those commands; then it writes values and pages.
"""

from __future__ import annotations

import json
import re
import shlex
import sys
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from string import Formatter
from tempfile import TemporaryDirectory
from typing import Any

import pytest

from tests.support.cli import answer
from tests.support.structure import ROOT

SENTENCES, VALUES = ROOT / "docs" / "figures.toml", ROOT / "docs" / "figures.json"
Scalar = float | int | str


@dataclass(frozen=True)
class Field:
    """A field of a sentence: the path to a value, and how it is formatted."""

    path: str
    spec: str

    @property
    def command(self) -> str:
        """Name of the command whose result holds the value."""
        return self.path.partition(".")[0]

    def format_values(self, values: Mapping[str, Scalar]) -> str:
        """The value as the page has it."""
        return format(values[self.path], self.spec)


@dataclass(frozen=True)
class Sentence:
    """A sentence of a page: literal text and fields in turn."""

    page: str
    parts: tuple[str | Field, ...]

    @classmethod
    def parse(cls, page: str, text: str) -> Sentence:
        """Return the sentence of a template."""
        parts: list[str | Field] = []
        for literal, path, spec, _ in Formatter().parse(text):
            parts += [literal] if path is None else [literal, Field(path, spec or "")]
        return cls(page, tuple(parts))

    @property
    def fields(self) -> list[Field]:
        return [part for part in self.parts if isinstance(part, Field)]

    def find(self, text: str) -> re.Match[str]:
        """Return where a page has the sentence, a group for each field.

        Raises LookupError where it has not.
        """
        match = re.search("".join(_pattern(part) for part in self.parts), text)
        if match is None:
            raise LookupError(
                f"{self.page} lacks: "
                f"{''.join(part if isinstance(part, str) else '*' for part in self.parts)}"
            )
        return match

    def renewed(self, text: str, values: Mapping[str, Scalar]) -> str:
        """Return a page's text with this sentence's fields as the values have them; line breaks
        stay.
        """
        match = self.find(text)
        for index, field in reversed(list(enumerate(self.fields, 1))):
            text = (
                text[: match.start(index)] + field.format_values(values) + text[match.end(index) :]
            )
        return text


def _pattern(part: str | Field) -> str:
    if isinstance(part, Field):
        return r"(-?[\d.]+(?:e[-+]\d+)?)" if part.spec else r"([^|\n]+?)"
    return r"\s+".join(re.escape(word) for word in re.split(r"\s+", part))


@cache
def listed() -> dict[str, Any]:
    """Commands, sentences and what else `docs/figures.toml` says."""
    return tomllib.loads(SENTENCES.read_text(encoding="utf-8"))


def sentences() -> Iterator[Sentence]:
    """Every sentence with figures, page by page."""
    for page in listed()["page"]:
        yield from (Sentence.parse(page["name"], text) for text in page["sentences"])


def fields() -> dict[str, Field]:
    """Every field by its path."""
    return {field.path: field for sentence in sentences() for field in sentence.fields}


def read_saved() -> dict[str, Scalar]:
    """The values of the last run."""
    return dict(json.loads(VALUES.read_text(encoding="utf-8"))) if VALUES.is_file() else {}


def measured(command: str) -> dict[str, Scalar]:
    """Run commands, or read a record, and return the values of its fields by path.

    Those before the last one write files, into a folder that is dropped afterwards.
    """
    stated = listed()["commands"][command]
    *before, call = [stated] if isinstance(stated, str) else stated
    record = ROOT / call
    if record.suffix == ".json":
        result = json.loads(record.read_text("utf-8"))
    else:
        with TemporaryDirectory() as folder, pytest.MonkeyPatch.context() as patch:
            for part in ("docs", "tests"):  # examples and the corpus have paths from the root
                (Path(folder) / part).symlink_to(ROOT / part)
            patch.chdir(folder)
            for preparation in before:
                answer(*shlex.split(preparation))
            result = answer(*shlex.split(call))
    return {
        path: lookup(result, path) for path, field in fields().items() if field.command == command
    }


def lookup(result: Any, path: str) -> Scalar:
    """The value at a path of a result.

    >>> lookup({"a": [{"law": "mean", "size": 2.0}]}, "command.a[mean].size")
    2.0
    """
    for key in re.findall(r"\.(\w+)|\[([^\]]+)\]", path):
        name = "".join(key)
        if isinstance(result, list):
            (result,) = [
                entry for entry in result if name in {_text(value) for value in entry.values()}
            ]
        else:
            result = result[name]
    return ", ".join(f"({number})" for number in result) if isinstance(result, list) else result


def _text(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


def renewed(page: str, values: Mapping[str, Scalar]) -> str:
    """A page's text with all its figures as the values have them."""
    text = (ROOT / page).read_text(encoding="utf-8")
    for sentence in sentences():
        if sentence.page == page:
            text = sentence.renewed(text, values)
    return text


def loose(page: str, text: str) -> list[str]:
    """Numbers in a page's prose that no sentence has, and that `plain` does not list as no
    results.
    """
    for sentence in sentences():
        if sentence.page == page:
            match = sentence.find(text)
            text = text[: match.start()] + re.sub(r"\d", "*", match[0]) + text[match.end() :]
    prose = "\n".join(line for line in text.splitlines() if not re.match(r" {4}|!\[|\|", line))
    for plain in (r"`[^`]*`", r"\]\([^)]*\)", *listed()["plain"]):
        prose = re.sub(plain, "", prose)
    return [line.strip() for line in prose.splitlines() if re.search(r"\d", line)]


def main(names: list[str]) -> None:
    """Renew the values of commands, without names those of quick ones and of any that has none yet,
    and all pages.
    """
    values = read_saved()
    lacking = {field.command for path, field in fields().items() if path not in values}
    usual = [
        name for name in listed()["commands"] if name not in listed()["slow"] or name in lacking
    ]
    for name in names or usual:
        values |= measured(name)
    values = {path: values[path] for path in sorted(fields())}
    VALUES.write_text(json.dumps(values, indent=1) + "\n", encoding="utf-8")
    for page in listed()["page"]:
        text = renewed(page["name"], values)
        (ROOT / page["name"]).write_text(text, encoding="utf-8")
        for line in loose(page["name"], text) if page.get("whole") else ():
            print(f"{page['name']}: no record has: {line}")


if __name__ == "__main__":
    main(sys.argv[1:])
