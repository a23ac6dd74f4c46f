"""What is kept of a command's result and files: every number, long lists by their length and
weighted sums.

Sentences are left out, which may be reworded: keys, numbers, truth values and words without a space
count. Source texts and drawings count by the byte.
"""

from __future__ import annotations

import csv
import hashlib
import json
import re
import shlex
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from itertools import zip_longest
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.support import own
from tests.support.cli import run

FOLDER = Path(__file__).parent
KEPT = FOLDER / "kept.json"
MECHANISMS = [path.stem for path in own.EXAMPLES.glob("*.py") if not path.stem.endswith("_paper")]
RELATIVE = 1e-12
"""How far numbers may stray, in parts of the largest of their list."""
LONG = 6
"""Lists of more numbers are kept as sums."""
TIMED = re.compile(
    r"(seconds|elapsed|version|_s_per_|files|folder|source|path)(\.|\[|$)|\.planter\.json"
)
"""Entries that say when, by what and where, not what."""
NUMBER = re.compile(r"[-+]?\d+(\.\d*)?(e[-+]?\d+)?")
TEXTS = {".c", ".h", ".dxf"}
ENTITIES = re.compile(rb"\nENTITIES\r?\n.*?\nENDSEC", re.DOTALL)
"""What a drawing draws; what stands before it had no fixed order."""

Entries = dict[str, Any]


def list_commands(is_long: bool) -> dict[str, list[str]]:
    """Return the words of each command by its name."""
    groups = tomllib.loads((FOLDER / "commands.toml").read_text(encoding="utf-8"))
    return {
        f"{group}.{name}": shlex.split(line)
        for group, lines in groups.items()
        for name, line in lines.items()
        if (group == "long") == is_long
    }


def read_kept() -> dict[str, Entries]:
    """Return the entries that are kept, by command."""
    recorded: dict[str, Entries] = json.loads(KEPT.read_text(encoding="utf-8"))
    return recorded


Tolerances = Mapping[str, Mapping[str, Any]]
"""By the pattern of entries that amplify rounding: a `relative` tolerance and its `reason`."""


def read_tolerances() -> dict[str, Tolerances]:
    """Return the tolerances of entries, by command."""
    return tomllib.loads((FOLDER / "tolerances.toml").read_text(encoding="utf-8"))


def evaluate(words: Sequence[str], folder: Path) -> Entries:
    """Return the entries of a command that runs in an empty folder."""
    names = [name for name in MECHANISMS if f"{{own}}/{name}.toml" in words]
    places = {"own": str(own.generated(names[0])) if names else "", "docs": str(own.EXAMPLES)}
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        code, out, err = run(*(word.format(**places) for word in words), "--json")
    assert code == 0, err
    return flatten(json.loads(out), folder)


def flatten(result: object, folder: Path) -> Entries:
    """Return the entries of a command's JSON object and of the files that it wrote into a
    folder.
    """
    entries = dict(_leaves("", result))
    for file in sorted(path for path in folder.rglob("*") if path.is_file()):
        name = f"{file.relative_to(folder).as_posix()}"
        if file.suffix in TEXTS:
            entries[name] = _digest(file.read_bytes())
        elif file.suffix == ".csv":
            entries |= dict(_columns(name, file))
    return {key: value for key, value in entries.items() if not TIMED.search(key)}


def compare(recorded: Entries, entries: Entries, tolerances: Tolerances) -> list[str]:
    """Return the entries that differ from the record, a line each."""
    lines = []
    for key in sorted(recorded.keys() | entries.keys()):
        before, now = recorded.get(key, "absent"), entries.get(key, "absent")
        pattern = next((pattern for pattern in tolerances if re.fullmatch(pattern, key)), None)
        relative = RELATIVE if pattern is None else tolerances[pattern]["relative"]
        if not _is_same(before, now, relative):
            lines.append(f"{key}: {before} before, {now} now")
    return lines


def _is_same(before: Any, now: Any, relative: float) -> bool:
    if isinstance(before, list) and isinstance(now, list) and len(before) == len(now):
        return bool(
            np.allclose(
                before, now, rtol=relative, atol=relative * max(map(abs, before), default=0.0)
            )
        )
    if _is_number(before) and _is_number(now):
        return bool(np.isclose(before, now, rtol=relative, atol=relative))
    return bool(before == now)


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _leaves(key: str, value: object) -> Iterator[tuple[str, Any]]:
    if isinstance(value, dict):
        for name, inner in value.items():
            yield from _leaves(f"{key}.{name}" if key else name, inner)
    elif isinstance(value, list) and value and all(map(_is_number, value)):
        yield key, _sums(value)
    elif isinstance(value, list):
        yield f"{key}.count", len(value)
        for index, inner in enumerate(value):
            yield from _leaves(f"{key}[{index}]", inner)
    elif not isinstance(value, str) or " " not in value:
        yield key, value


def _digest(content: bytes) -> str:
    entities = ENTITIES.search(content)
    return hashlib.sha256(entities[0] if entities else content).hexdigest()[:16]


def _columns(name: str, file: Path) -> Iterator[tuple[str, Any]]:
    """Yield the sums of each column's numbers, and a digest of its texts, its title among them."""
    with file.open(encoding="utf-8", newline="") as stream:
        columns = zip_longest(*csv.reader(stream), fillvalue="")
    for index, column in enumerate(columns):
        numbers = [float(text) for text in column if NUMBER.fullmatch(text)]
        texts = "\n".join(text for text in column if not NUMBER.fullmatch(text))
        yield f"{name}[{index}]", _sums(numbers)
        yield f"{name}[{index}].texts", _digest(texts.encode())


def _sums(numbers: Sequence[float]) -> list[float]:
    """Return a list as it is if it is short, else its length, largest size, and three sums that
    tell orders apart.
    """
    if len(numbers) <= LONG:
        return list(numbers)
    x = np.array(numbers, dtype=float)
    waves = [float(x @ np.cos(k * np.arange(1, len(x) + 1)) / np.sqrt(len(x))) for k in (0, 1, 2)]
    return [float(len(x)), float(np.abs(x).max()), *waves]
