"""Works to cite for the results of commands, from `references.toml` of each package."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources

from planter import paths, plugins
from planter.cli.results import Cited
from planter.errors import InputError
from planter.text_files import parse_toml
from planter.version import __version__

FILE = "references.toml"
OWN = "planter"
"""Key of this program, on which every result rests."""
_OURS = ("type", "for")
"""Keys of the files that are no fields of BibTeX."""


@dataclass(frozen=True)
class References:
    """Works by key, each a table of BibTeX's fields with `type` and its purpose `for`; keys of
    works by command.
    """

    works: Mapping[str, Mapping[str, str]]
    commands: Mapping[str, list[str]]


@cache
def load_references() -> References:
    """Return the works of all packages; of a command in several files, works of machines precede
    shared ones.
    """
    works: dict[str, Mapping[str, str]] = {}
    commands: dict[str, list[str]] = {}
    for package in sorted(
        plugins.find_packages().values(), key=lambda package: package == __package__
    ):
        file = resources.files(package).joinpath(FILE)
        if file.is_file():
            table = parse_toml(file.read_text(encoding="utf-8"), file.name)
            works |= table["works"]
            for command, keys in table["commands"].items():
                commands.setdefault(command, []).extend(keys)
    return References(works, commands)


def cite_works(name: str) -> list[Cited]:
    """Return the works behind a command, this program first, or the work of a key.

    Raises InputError for any other name.
    """
    index = load_references()
    if name in index.works:
        return [cite_work(name)]
    if name in index.commands:
        return [cite_work(key) for key in (OWN, *index.commands[name])]
    names = [*index.works, *index.commands]
    hint = paths.suggest_names(name, names, "planter about cite lists the works and commands")
    raise InputError.for_value(
        "NAME", name, f"it is neither a work nor a command based on one, {hint}"
    )


def cite_work(key: str) -> Cited:
    """Return the work of a key."""
    fields = dict(load_references().works[key])
    if key == OWN:
        fields["version"] = __version__
    return Cited(
        key, fields.get("for", "this program"), format_line(fields), format_bibtex(key, fields)
    )


def format_line(fields: Mapping[str, str]) -> str:
    """Return a work in one line.

    >>> format_line({"author": "Shapley, Lloyd S.", "title": "A Value", "year": "1953", "pages": "307--317"})
    'Shapley, Lloyd S.: A Value. 1953, pp. 307-317.'
    """
    authors = fields["author"].strip("{}").replace(" and others", " et al.").replace(" and ", "; ")
    parts = [fields[key] for key in ("journal", "booktitle", "publisher", "year") if key in fields]
    patterns = {
        "version": "version {}",
        "volume": "vol. {}",
        "number": "no. {}",
        "pages": "pp. {}",
        "doi": "doi:{}",
    }
    parts += [
        words.format(fields[key].replace("--", "-"))
        for key, words in patterns.items()
        if key in fields
    ]
    note = f" ({fields['note']})" if "note" in fields else ""
    return f"{authors}: {fields['title']}. {', '.join(parts)}{note}."


def format_bibtex(key: str, fields: Mapping[str, str]) -> str:
    """Return a work as an entry of BibTeX; the capitals of its title are protected."""
    entries = {name: value for name, value in fields.items() if name not in _OURS}
    entries["title"] = f"{{{entries['title']}}}"
    lines = [f"  {name} = {{{value}}}" for name, value in entries.items()]
    return f"@{fields['type']}{{{key},\n" + ",\n".join(lines) + "\n}"
