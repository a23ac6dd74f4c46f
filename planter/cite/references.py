"""Works and what rests on them, as the rooms' files `references.toml` say, in words and as BibTeX."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources

from planter import plugins
from planter.cite.results import Cited
from planter.errors import InputError
from planter.files import paths
from planter.files.text import parse_toml
from planter.version import __version__

FILE = "references.toml"
OWN = "planter"
"""The work that every result rests on."""
_OURS = ("type", "for")
"""Fields that are not BibTeX's."""


@dataclass(frozen=True)
class References:
    """Works by key, each a table of BibTeX's fields with `type` and what it is `for`; keys of works by command."""

    works: Mapping[str, Mapping[str, str]]
    commands: Mapping[str, list[str]]


@cache
def references() -> References:
    """Those of all rooms; of a command that several speak of, works of machines come before what they share."""
    works: dict[str, Mapping[str, str]] = {}
    commands: dict[str, list[str]] = {}
    for package in sorted(plugins.find_packages().values(), key=lambda package: package == __package__):
        file = resources.files(package).joinpath(FILE)
        if file.is_file():
            found = parse_toml(file.read_text(encoding="utf-8"), file.name)
            works |= found["works"]
            for command, keys in found["commands"].items():
                commands.setdefault(command, []).extend(keys)
    return References(works, commands)


def cited(name: str) -> list[Cited]:
    """The works behind a command, this program first, or the one of a key. Raises InputError for any other name."""
    known = references()
    if name in known.works:
        return [work(name)]
    if name in known.commands:
        return [work(key) for key in (OWN, *known.commands[name])]
    names = [*known.works, *known.commands]
    close = paths.close(name, names)
    hint = f"did you mean {' or '.join(close)}?" if close else "planter cite lists the works and commands"
    raise InputError(f"NAME = {name} is not allowed: it is no work and no command that rests on one, {hint}")


def work(key: str) -> Cited:
    """A work by its key."""
    fields = dict(references().works[key])
    if key == OWN:
        fields["version"] = __version__
    return Cited(key, fields.get("for", "this program"), plain(fields), bibtex(key, fields))


def plain(fields: Mapping[str, str]) -> str:
    """A work in one line.

    >>> plain({"author": "Shapley, Lloyd S.", "title": "A Value", "year": "1953", "pages": "307--317"})
    'Shapley, Lloyd S.: A Value. 1953, pp. 307-317.'
    """
    authors = fields["author"].strip("{}").replace(" and others", " et al.").replace(" and ", "; ")
    places = [fields[key] for key in ("journal", "booktitle", "publisher", "year") if key in fields]
    told = {"version": "version {}", "volume": "vol. {}", "number": "no. {}", "pages": "pp. {}", "doi": "doi:{}"}
    places += [words.format(fields[key].replace("--", "-")) for key, words in told.items() if key in fields]
    note = f" ({fields['note']})" if "note" in fields else ""
    return f"{authors}: {fields['title']}. {', '.join(places)}{note}."


def bibtex(key: str, fields: Mapping[str, str]) -> str:
    """A work as an entry of BibTeX; capitals of its title stay."""
    own = {name: value for name, value in fields.items() if name not in _OURS}
    own["title"] = f"{{{own['title']}}}"
    lines = [f"  {name} = {{{value}}}" for name, value in own.items()]
    return f"@{fields['type']}{{{key},\n" + ",\n".join(lines) + "\n}"
