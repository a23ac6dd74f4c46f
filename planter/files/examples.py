"""Built-in files by name, from the folders `examples` of the packages of machines."""

from __future__ import annotations

import itertools
import os
import re
from collections.abc import Mapping
from functools import cache
from importlib import import_module
from importlib.resources.abc import Traversable
from pathlib import Path
from types import ModuleType
from typing import Any, Literal, NoReturn

from planter import paths, plugins, safe_text
from planter.errors import InputError
from planter.text_files import is_file, parse_toml, read_text, read_toml

Suffix = Literal[".toml", ".csv"]
SUFFIXES: tuple[Suffix, ...] = (".toml", ".csv")
_SENTENCE_END = re.compile(r"\.\s+(?=[A-Z])")
_EVERYWHERE = {"name", "description", "origin"}
"""Keys that all kinds of files have."""
_ALIKE = 0.5
"""Share of common tables above which a file counts as one of a kind."""


def list_examples(kind: str | None = None, suffix: Suffix | None = None) -> list[str]:
    """Return the sorted names of built-in files: all, or those of one package or of one suffix."""
    return sorted(
        file.name.rpartition(".")[0] for file in _files(kind) if file.name.endswith(suffix or "")
    )


def describe_examples() -> dict[str, str]:
    """Return the built-in files by name, each with the first sentence of the comment that it begins
    with.
    """
    texts = {
        file.name.rpartition(".")[0]: file.read_text(encoding="utf-8") for file in _files(None)
    }
    return {name: _read_sentence(texts[name]) for name in sorted(texts)}


def _read_sentence(text: str) -> str:
    lines = itertools.takewhile(lambda line: line.startswith("#"), text.splitlines())
    comment = " ".join(line.removeprefix("#").strip() for line in lines)
    return _SENTENCE_END.split(comment, maxsplit=1)[0].rstrip(".")


def example(name: str, kind: str | None = None, suffix: Suffix | None = None) -> str:
    """Return the commented text of a built-in file. Raises InputError for an unknown name."""
    for file in _files(kind):
        if file.name.rpartition(".")[0] == name and file.name.endswith(suffix or ""):
            return file.read_text(encoding="utf-8")
    builtin = list_examples(kind, suffix)
    similar = paths.find_similar(name, builtin)
    noun = "machine" if suffix == ".toml" else "example"
    if kind and (other := _elsewhere(name)):
        raise InputError(
            f"{name}: {other}, but it must be one of {', '.join(builtin)} or the path of a "
            f"{suffix} file"
        )
    hint = f": did you mean {similar[0]}?" if similar else ""
    raise InputError(
        f"{name or safe_text.quote_name(name)}: there is no built-in {noun} of that name{hint} "
        f"(built in: {', '.join(builtin)}; anything else must be the path of a "
        f"{suffix or '.toml or .csv'} file)"
    )


def read_source(source: str | Path, kind: str | None = None, suffix: Suffix = ".toml") -> str:
    """Return the text of the file at a path, or of the built-in file of that name, of any package
    or of one.

    Raises InputError if there is neither, if the file cannot be read, or if its name has the other
    suffix.
    """
    if _is_name(source, kind, suffix):
        return example(str(source), kind, suffix)
    other = next(
        (
            ending
            for ending in SUFFIXES
            if ending != suffix and str(source).lower().endswith(ending)
        ),
        None,
    )
    if other is not None:
        builtin = ", ".join(list_examples(kind, suffix))
        raise InputError(
            f"{source}: this is a {other} file, but it must be a {suffix} file or built in "
            f"({builtin})"
        )
    return read_text(source)


def refuse_machine(source: str) -> NoReturn:
    """Raise InputError that says why a source, which no package takes, is not a machine.

    It is unknown, unreadable, no TOML, a statement that is not derived yet, or has tables of no
    kind of machine.
    """
    if source.endswith(".py") and is_file(Path(source)):
        raise InputError(
            f"{source}: this is a statement in Python, but it must be a .toml file: "
            f"`planter derive {source}` writes one"
        )
    keys = ", ".join(parse_toml(read_source(source), source))
    raise InputError(
        f"{source}: this file does not describe a machine: it has "
        f"{safe_text.sanitise_line(keys, 200) or 'no tables'}, but no kind of machine has that; "
        f"`planter new` lists files to start from"
    )


def belongs_to_package(source: str, kind: str, tables: set[str]) -> bool:
    """Return whether a source is a built-in machine of a package, or a TOML file with the tables of
    its machines.
    """
    if source in list_examples(kind, ".toml"):
        return True
    try:
        return set(read_toml(source)) >= tables
    except InputError:
        return False


def resembles_package(source: str, kind: str) -> bool:
    """Return whether a source is a built-in machine of a package, or a TOML file most similar to
    its files.
    """
    if source in list_examples(kind, ".toml"):
        return True
    try:
        alike = _alike(read_toml(source))
    except InputError:
        return False
    return 0 < alike.get(kind, 0) == max(alike.values())


def check_kind(table: Mapping[str, Any], source: str, kind: str) -> None:
    """Raise InputError if a file belongs to another kind of machine, by the names of its tables."""
    alike = _alike(table)
    best = max(alike, key=lambda package: alike[package])
    if best != kind and alike[best] > max(_ALIKE, alike.get(kind, 0)):
        builtin = ", ".join(list_examples(kind, ".toml"))
        raise InputError(
            f"{source}: this is a file for {_takers(best)}, but it must be one like {builtin}"
        )


def _elsewhere(name: str) -> str | None:
    """Return a description of a built-in file of another command, or of another kind; None without
    one.
    """
    for package in sorted(plugins.find_folders("examples")):
        for file in _files(package):
            if file.name.rpartition(".")[0] == name:
                return (
                    f"this is a built-in {file.name.rpartition('.')[2].upper()} file for "
                    f"{_takers(package)}"
                )
    return None


def _takers(package: str) -> str:
    return f"planter {', '.join(plugins.list_commands(package))}"


def _alike(table: Mapping[str, Any]) -> dict[str, float]:
    """Return the similarity of a table to the files of each package."""
    return {package: _likeness(table, package) for package in plugins.find_folders("examples")}


def _likeness(table: Mapping[str, Any], package: str) -> float:
    """Return the largest share of top-level keys that a table has in common with a built-in file of
    a package.
    """
    keys = set(table) - _EVERYWHERE
    return max(
        (len(keys & other) / len(keys | other) for other in _tables(package) if keys | other),
        default=0,
    )


@cache
def _tables(package: str) -> list[set[str]]:
    """Return the names of the tables of each built-in file of a package."""
    builtin = (
        (file.read_text(encoding="utf-8"), file.name)
        for file in _files(package)
        if file.name.endswith(".toml")
    )
    return [set(parse_toml(content, name)) - _EVERYWHERE for content, name in builtin]


def _is_name(source: str | Path, kind: str | None, suffix: Suffix) -> bool:
    if isinstance(source, Path):
        return False
    if source in list_examples(kind, suffix):
        return True
    return not (
        source.lower().endswith(SUFFIXES) or Path(source).name != source or os.path.exists(source)
    )


@cache
def _files(kind: str | None) -> list[Traversable]:
    by_package = plugins.find_folders("examples")
    packages = [kind] if kind else sorted(by_package)
    folders = [by_package[package] for package in packages if package in by_package]
    return [file for folder in folders for file in folder.iterdir() if file.name.endswith(SUFFIXES)]


def find_kind(source: str) -> ModuleType | None:
    """Return the module `machines` of the package that takes a source, or None."""
    for name, package in plugins.find_packages().items():  # no other package's machines are loaded
        tables = getattr(import_module(package), "OWN_TABLES", None)
        if tables is not None and belongs_to_package(source, name, tables):
            return import_module(f"{package}.machines")
    for module in plugins.load_modules("machines"):
        if hasattr(module, "takes") and module.takes(source):
            return module
    return None


def load_part(source: str, part: str) -> ModuleType | None:
    """Return a module by its name of the package that takes a source, or of the one whose files a
    file resembles.

    None if there is no such package, or if it has no such module.
    """
    kind = find_kind(source)
    for module in plugins.load_modules(part):
        package = plugins.name_package(module)
        if package == plugins.name_package(kind) if kind else resembles_package(source, package):
            return module
    return None
