"""Commands that belong to no machine: built-in files, derivation, schemas, topics of help, papers
to cite.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources
from pathlib import Path
from textwrap import fill
from typing import Annotated

import typer

from planter import paths, plugins
from planter.cli.results import (
    Citable,
    Citations,
    Cited,
    Derived,
    Example,
    Examples,
    Listed,
    Topic,
    Topics,
)
from planter.errors import InputError
from planter.files import derivation, examples
from planter.report.console import Console
from planter.report.folder import NAME
from planter.report.options import JsonOption, list_allowed, refuse_unused
from planter.report.writing import OverwriteOption
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
    hint = paths.suggest_names(name, names, "planter cite lists the works and commands")
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


app = typer.Typer()


@app.command()
def example(
    name: Annotated[
        str | None, typer.Argument(help="a built-in machine or data file", show_default=False)
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """List built-in machines and data files, or print one."""
    console = Console(as_json)
    with console.outcome():
        if name is None:
            described = examples.describe_examples()
            rows = list(described.items())
            console.result(
                Examples(list(described), described),
                lambda: console.table("Built-in files", ("name", "content"), rows),
            )
        else:
            text = examples.example(name)
            console.result(Example(name, text), lambda: print(text, end=""))


FileArgument = Annotated[
    Path,
    typer.Argument(
        metavar="FILE",
        help="a Python file, a folder of such files, or a robot (.urdf)",
        show_default=False,
    ),
]
FolderOption = Annotated[
    Path | None,
    typer.Option(
        "--out", help="folder to write to [default: generated, next to FILE]", show_default=False
    ),
]
TargetOption = Annotated[
    list[str] | None,
    typer.Option(
        "--target",
        metavar="NAME",
        help="also write this language (repeatable): matlab (function files for MATLAB and "
        "Octave), latex (the "
        "derivation as a document with numbered equations), or one that an installed package offers",
        show_default=False,
    ),
]


def _is_derived(path: Path) -> bool:
    return path.is_file() and "__pycache__" not in path.parts and path.name != NAME


@app.command()
def derive(
    source: FileArgument,
    out: FolderOption = None,
    target: TargetOption = None,
    overwrite: OverwriteOption = False,
    as_json: JsonOption = False,
) -> None:
    """Derive the equations of your mechanism. FILE is run as Python: only use files you trust."""
    console = Console(as_json)
    with console.outcome():
        folder = derivation.derive_file(source, out, target or (), overwrite)
        written = sorted(str(path) for path in folder.rglob("*") if _is_derived(path))
        console.result(Derived(str(folder), written), lambda: print("\n".join(written)))


@app.command()
def schema(
    command: Annotated[
        list[str] | None, typer.Argument(help="a command, as `clutch geometry`", show_default=False)
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """List the commands with a JSON schema, or print one schema."""
    console = Console(as_json)
    with console.outcome():
        from planter import paths
        from planter.files import schema as schemas

        kinds, name = schemas.load_result_types(), " ".join(command or ())
        if not name:
            listed = sorted(kinds)
            console.result(Listed(listed), lambda: print("\n".join(listed)))
            return
        if name not in kinds:
            raise InputError.for_value("COMMAND", name, paths.suggest_names(name, sorted(kinds)))
        console.result(
            dict(schemas.build_schema(name, kinds[name])),
            lambda: print(schemas.format_schema(name, kinds[name]), end=""),
        )


_FOLDER = resources.files(__package__).joinpath("topics")


def list_topics() -> list[str]:
    """Return the names of the topics, sorted."""
    return sorted(
        page.name.removesuffix(".md") for page in _FOLDER.iterdir() if page.name.endswith(".md")
    )


def read_topic(topic: str) -> str:
    """Return the page of a topic. Raises InputError for an unknown name."""
    from planter import paths

    allowed = list_topics()
    if topic not in allowed:
        raise InputError.for_value("TOPIC", topic, paths.suggest_names(topic, allowed))
    return _FOLDER.joinpath(f"{topic}.md").read_text(encoding="utf-8")


@app.command(name="help", cls=list_allowed(topic=list_topics))
def help_topics(
    topic: Annotated[
        str | None, typer.Argument(help="what to read about", show_default=False)
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """List the topics that concern all commands, or print one."""
    console = Console(as_json)
    with console.outcome():
        if topic is None:
            listed = list_topics()
            console.result(Topics(listed), lambda: print("\n".join(listed)))
        else:
            page = read_topic(topic)
            console.result(Topic(topic, page), lambda: print(page, end=""))


@app.command()
def cite(
    name: Annotated[
        list[str] | None,
        typer.Argument(
            help="a command, as `optimise` or `clutch engage`, or a work, as wang2017",
            show_default=False,
        ),
    ] = None,
    bibtex: Annotated[
        bool, typer.Option("--bibtex", help="entries for BibTeX instead of lines")
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """List the works to cite for a command's result. For example: planter cite optimise --bibtex"""
    console = Console(as_json)
    with console.outcome():
        if not name:
            refuse_unused("without a NAME", "--bibtex")
            index = load_references()
            listed = Citable(sorted(index.works), dict(sorted(index.commands.items())))
            lines = [
                f"works: {', '.join(listed.works)}",
                *(f"{k}: {', '.join(v)}" for k, v in listed.commands.items()),
            ]
            console.result(listed, lambda: print("\n".join(lines)))
            return
        title = " ".join(name)
        result = Citations(title, cite_works(title))
        console.result(
            result,
            lambda: print("\n\n".join(w.bibtex if bibtex else _wrap(w) for w in result.works)),
        )


def _wrap(work: Cited) -> str:
    return fill(
        f"{work.key} ({work.behind}): {work.text}",
        80,
        subsequent_indent="  ",
        break_on_hyphens=False,
    )


@app.command("prove")
def check_proof(
    file: Annotated[
        Path,
        typer.Argument(metavar="FILE", help="a proof.json of optimise --prove", show_default=False),
    ],
    check: Annotated[
        bool, typer.Option("--check", help="compute each of its bounds again (the default)")
    ] = True,
    as_json: JsonOption = False,
) -> None:
    """Compute each bound of a proof again, from its file alone.

    Exit code 1 if one does not follow. `check_proof.py` beside the file does the same without
    planter.
    """
    console = Console(as_json)
    with console.outcome():
        from planter.engine.proof.certificate_file import check_document, read_document

        result = check_document(read_document(file))
        console.result(result, lambda: print(result.describe()))
    if not result.valid:
        raise typer.Exit(1)
