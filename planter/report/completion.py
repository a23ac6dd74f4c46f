"""What a shell completes: names of built-in files, files, and keys for `--set`.

Typer drops what does not continue the word that was begun.
"""

from __future__ import annotations

import glob
from collections.abc import Callable, Iterator
from itertools import islice
from pathlib import Path

import typer

from planter import paths
from planter.errors import InputError
from planter.files import examples
from planter.text_files import parse_toml, read_toml

MOST = 200
"""Number of files that are offered at most."""


def complete_sources(
    kind: str | None = None, suffix: examples.Suffix = ".toml"
) -> Callable[[str], list[str]]:
    """Return a completion by built-in files, of all packages if `kind` is None, and by files."""

    def complete(incomplete: str) -> list[str]:
        return [*examples.list_examples(kind, suffix), *_list_files(incomplete, suffix)]

    return complete


complete_machines = complete_sources()


def complete_files(*suffixes: str) -> Callable[[str], list[str]]:
    """Return a completion by files with one of some suffixes."""

    def complete(incomplete: str) -> list[str]:
        return [name for suffix in suffixes for name in _list_files(incomplete, suffix)]

    return complete


def complete_changes(context: typer.Context) -> list[tuple[str, str]]:
    """Return the numbers of the call's machine as `KEY=`, each with its present value: full paths,
    and last parts that are unique.
    """
    if not context.args:  # the words without the unfinished option: the machine is the first
        return []
    try:
        numbers = dict(_list_numbers(context.args[0]))
    except InputError:
        return []
    names = paths.Names(list(numbers))
    ends = {paths.last_part(path): path for path in numbers}
    short = {end: path for end, path in ends.items() if names.candidates(end) == [path]}
    entries = {path: path for path in numbers} | short
    return [(f"{name}=", f"now {numbers[path]:g}") for name, path in entries.items()]


def _list_numbers(source: str) -> Iterator[tuple[str, float]]:
    """Yield the numbers of a machine's file by path. Raises InputError if it cannot be read."""
    if source in examples.list_examples(suffix=".toml"):
        table = parse_toml(examples.example(source), source)
    else:
        path = Path(source if source.endswith(".toml") else f"{source}.toml")
        table = read_toml(path if path.exists() else Path("generated", path))
    for path_, value in paths.walk_paths(table):
        is_changeable = not path_.startswith(("bounds.", "origin."))
        if is_changeable and isinstance(value, int | float) and not isinstance(value, bool):
            yield path_, value


def _list_files(incomplete: str, suffix: str) -> list[str]:
    """Return files of the folder that a text begins with and of the folders in it, sorted.

    Folders are not offered, since a shell would end the word behind them.
    """
    folder = incomplete[: incomplete.rfind("/") + 1]
    rest = incomplete.removeprefix(folder)
    start = glob.escape(rest)
    patterns = (f"{start}*{suffix}", f"{start}*/*{suffix}")
    try:
        matches = (path for pattern in patterns for path in Path(folder or ".").glob(pattern))
        return sorted(f"{folder}{_relative(path, folder)}" for path in islice(matches, MOST))
    except (OSError, ValueError, NotImplementedError):
        return []


def _relative(path: Path, folder: str) -> str:
    return path.relative_to(Path(folder or ".")).as_posix()
