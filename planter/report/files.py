"""Result files: CSV and JSON without rounding, with their provenance.

A file is replaced at once, never in part.
"""

from __future__ import annotations

import hashlib
import json
import math
import platform
from collections.abc import Iterable, Iterator, Mapping, Sequence
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from planter import paths
from planter.errors import ComputationError
from planter.files import csv_rows
from planter.progress import Listener, ProgressPhase
from planter.report import folder, style
from planter.report.folder import output_folder as output_folder
from planter.report.folder import renews_files
from planter.safe_text import file_name
from planter.version import __version__

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from planter.files.document import Document
    from planter.kernels import Array


def write_bytes(path: Path, content: bytes) -> None:
    """Write a result file, and enter it in the manifest of its folder.

    Raises InputError, naming the path, if it cannot be written or would replace a file that planter
    did not write.
    """
    folder.write_file(path, content)


def write_all(out: str | Path, contents: Mapping[str, str | bytes]) -> list[str]:
    """Write texts and bytes by file name into a folder, and return their paths.

    Raises InputError as `write_bytes` does, before any file is written.
    """
    folder.check_files(out, contents)
    for parent in {(Path(out) / name).parent for name in contents}:
        output_folder(parent)
    for name, content in contents.items():
        write_bytes(Path(out) / name, _encoded(content) if isinstance(content, str) else content)
    return [str(Path(out) / name) for name in contents]


def write_text(path: Path, text: str) -> None:
    """Write a text in UTF-8 with its line ends unchanged, as `write_bytes` does.

    Lone surrogates, which undecodable file names contain, are written as backslash escapes.
    """
    write_bytes(path, _encoded(text))


def _encoded(content: str) -> bytes:
    return content.encode("utf-8", "backslashreplace")


def cycle_csv(
    name: str, comments: Iterable[str], columns: Mapping[str, Array | Sequence[float]]
) -> str:
    """Return columns (n,) by name as CSV text, after comment lines that start with `#`.

    Numbers are the shortest text that reads back to the same bits.

    Raises ComputationError, naming the file `name`, if columns differ in length or a value is not
    finite.
    """
    arrays = {column: np.asarray(values, dtype=float) for column, values in columns.items()}
    _check_columns(name, arrays)
    return csv_rows.format_csv(
        comments, arrays, zip(*(array.tolist() for array in arrays.values()), strict=True)
    )


def _check_columns(path: str, arrays: Mapping[str, Array]) -> None:
    shapes = {name: array.shape for name, array in arrays.items()}
    if len(set(shapes.values())) != 1 or len(next(iter(shapes.values()))) != 1:
        raise ComputationError(
            f"{path}: the columns must be lists of equal length; their shapes are {shapes}"
        )
    for name, array in arrays.items():
        if not np.isfinite(array).all():
            row = int(np.argmin(np.isfinite(array)))
            raise ComputationError(f"{path}: {name} is not finite in row {row}: {array[row]}")


def write_summary(path: Path, summary: Mapping[str, Any]) -> None:
    """Write a summary as JSON without rounding.

    Raises ComputationError, naming the key, if a number is not finite, and InputError if the file
    cannot be written.
    """
    write_text(path, summary_text(summary))


def summary_text(summary: Mapping[str, Any]) -> str:
    """Return a summary as standard JSON text.

    Raises ComputationError, naming the key, if a number is not finite.
    """
    plain = _plain(summary)
    for key, value in paths.walk_paths(plain):
        if isinstance(value, float) and not math.isfinite(value):
            raise ComputationError(
                f"the result {key} = {value} is not finite, so no summary is written"
            )
    return json.dumps(plain, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def _plain(value: Any) -> Any:
    """Return the value with NumPy scalars and arrays as Python numbers and lists."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return _plain(value.tolist())
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return value


def list_versions() -> dict[str, str]:
    """Return the versions of this program and of what its numbers depend on."""
    return {
        "planter": __version__,
        "casadi": metadata.version("casadi"),
        "numpy": metadata.version("numpy"),
        "python": platform.python_version(),
    }


def list_provenance(machine: Document, seed: int | None = None) -> dict[str, Any]:
    """Return what a run can be repeated from: versions, the machine, and a hash of its values.

    The hash covers the values, including those set on the command line, but not the layout or path
    of the file.
    """
    content = json.dumps(machine.table(), sort_keys=True, allow_nan=False).encode("utf-8")
    record: dict[str, Any] = {
        **list_versions(),
        "machine": machine.name,
        "machine_sha256": hashlib.sha256(content).hexdigest(),
        "changed": list(machine.changed),
    }
    return record if seed is None else record | {"seed": seed}


def write_unfinished(out: Path, machine: Document, table: Mapping[str, Any]) -> None:
    """Write what a command has computed of a machine so far to summary.json, which says that it is
    not finished.
    """
    basis = {"input": machine.table(), "provenance": list_provenance(machine)}
    write_summary(output_folder(out) / "summary.json", {**table, "finished": False, **basis})


def list_comments(
    machine: Document, kind: str, more: Iterable[str] = (), seed: int | None = None
) -> Iterator[str]:
    """Yield the header lines of a CSV: the machine, named by its kind, the lines `more`, and the
    provenance.
    """
    yield f"{kind}: {machine.name} ({machine.description})"
    yield from more
    record = list_provenance(machine, seed)
    yield "versions: " + ", ".join(f"{name} {text}" for name, text in list_versions().items())
    yield f"machine_sha256: {record['machine_sha256']}"
    if machine.changed:
        yield "set on the command line: " + ", ".join(machine.changed)
    if seed is not None:
        yield f"seed: {seed}"


RenderedFigure = Mapping[str, str | bytes]
"""A figure by the endings of its files."""


def render_figures(
    figures: Mapping[str, Figure], progress: Listener | None = None
) -> dict[str, RenderedFigure]:
    """Render figures by name as SVG, PNG and PDF, and report the number of rendered figures to
    `progress`.
    """
    rendered: dict[str, RenderedFigure] = {}
    phase = ProgressPhase("drawing", "figure", len(figures), progress)
    for name, figure in figures.items():
        rendered[name] = style.render_figure(figure)
        phase.advance(name)
    return rendered


@renews_files
def write_bundle(
    out: str | Path, texts: Mapping[str, str | bytes], figures: Mapping[str, RenderedFigure]
) -> None:
    """Write texts by file name, and figures into the folder `figures`.

    Raises InputError, naming the path, before any file is written if the folder cannot be written
    or if it has a file of one of these names that planter did not write.
    """
    contents: dict[str, str | bytes] = {}
    for name, figure in figures.items():
        stem, count = file_name(name), 1
        while (
            f"figures/{stem}.svg" in contents
        ):  # names that differ only in characters which file names cannot have
            count += 1
            stem = f"{file_name(name)}-{count}"
        contents |= {f"figures/{stem}.{ending}": content for ending, content in figure.items()}
    write_all(out, contents | dict(texts))
