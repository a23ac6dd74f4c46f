"""Generated folders on the disk, written and compared; errors of user files, each with its
place.
"""

from __future__ import annotations

import hashlib
import json
import os
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


class OwnError(Exception):
    """A sentence on what is wrong with what a user wants derived; then the lines of the user's own
    that led there.
    """


@contextmanager
def blame_user_file(path: Path) -> Iterator[None]:
    """Turn what a file or folder raises into an OwnError."""
    try:
        yield
    except OwnError:
        raise
    except Exception as error:
        raise OwnError(describe_error(error, path)) from error


def describe_error(error: Exception, path: Path) -> str:
    """The place in the user's files and what was raised, then the user's own lines of the
    traceback.
    """
    folder = (path if path.is_dir() else path.parent).resolve()
    frames = [
        frame for frame in traceback.extract_tb(error.__traceback__) if _in(folder, frame.filename)
    ]
    place, message = str(path), " ".join(str(error).split())
    if isinstance(error, SyntaxError) and error.filename:
        place, message = f"{error.filename}, line {error.lineno}", str(error.msg)
    elif frames:
        place = f"{frames[-1].filename}, line {frames[-1].lineno}"
    lines = "".join(traceback.format_list(frames)).rstrip()
    return f"{place}: {type(error).__name__}: {message}" + (f"\n{lines}" if lines else "")


def _in(folder: Path, filename: str) -> bool:
    """Whether a file is the user's: in the folder, neither of this package nor installed."""
    file = Path(filename).resolve()
    ours = file.is_relative_to(Path(__file__).resolve().parent)
    return file.is_relative_to(folder) and not ours and "site-packages" not in file.parts


LIST = ".planter.json"
"""The list of what was written into a folder."""
GENERATED = Path(__file__).parents[1] / "generated"
"""Where a checkout keeps what is derived."""


def write_folder(
    folder: Path, content: dict[str, str], kept_files: frozenset[str] = frozenset()
) -> None:
    """Write every text; nothing that stands there besides is kept, but what other parts wrote."""
    for stray in list_strays(folder, content):
        if stray.relative_to(folder).as_posix() not in kept_files:
            stray.unlink()
    for name, text in content.items():
        _put(folder / name, text)


def add_files(folder: Path, content: dict[str, str], overwrite: bool = False) -> None:
    """Write every text, or none where that would replace a file that was not derived, or that was
    edited since.

    What stands there besides is left alone. Each folder's list of hashes says what was derived;
    `overwrite` does not ask it. Raises OwnError, naming the file.
    """
    folders: dict[Path, dict[str, str]] = {}
    for name, text in content.items():
        folders.setdefault((folder / name).parent, {})[(folder / name).name] = text
    lists = {place: _listed(place) for place in folders}
    for place, texts in folders.items():
        for name, text in texts.items():
            known_hashes = {
                _hash(text.encode()),
                *(part.get(name, "") for part in lists[place].values()),
            }
            if (
                os.path.lexists(place / name)
                and not overwrite
                and not _is_one_of(place / name, known_hashes)
            ):
                raise OwnError(
                    f"{place / name}: this was not derived, or it was edited since, and it is not "
                    f"overwritten; rename "
                    "it, choose another --out, or add --overwrite"
                )
    for place, texts in folders.items():
        _write_listed(place, texts, lists[place])


def _write_listed(place: Path, texts: dict[str, str], listed: dict[str, dict[str, str]]) -> None:
    """Write the files of one folder; their list comes first, with the hashes from before, in case
    of a kill.
    """
    before = {
        name: part[name]
        for part in (listed["files"], listed["independent"])
        for name in texts
        if name in part
    }
    files = {name: value for name, value in listed["files"].items() if name not in texts}
    after = listed["independent"] | {name: _hash(text.encode()) for name, text in texts.items()}
    parts = {
        "files": files,
        "independent": dict(sorted(after.items())),
        "earlier": listed["earlier"] | before,
    }
    _put(
        place / LIST,
        json.dumps(
            {name: part for name, part in parts.items() if part or name == "files"}, indent=1
        ),
    )
    for name, text in texts.items():
        _put(place / name, text)


def _put(path: Path, text: str) -> None:
    """Write a file at once: whoever looks sees the old text or the new.

    Raises OwnError where it cannot be written.
    """
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        part.write_text(text, encoding="utf-8", newline="\n")
        os.replace(part, path)
    except OSError as error:
        part.unlink(missing_ok=True)
        raise OwnError(f"{path}: this cannot be written ({error.strerror})") from None


def _listed(place: Path) -> dict[str, dict[str, str]]:
    """The parts of a folder's list, as `planter.report.folder` has it: hashes by name; empty where
    there is none.
    """
    try:
        content = json.loads((place / LIST).read_text(encoding="utf-8"))
        return {part: dict(content.get(part, {})) for part in ("files", "independent", "earlier")}
    except (OSError, ValueError, TypeError, AttributeError, RecursionError):
        return {"files": {}, "independent": {}, "earlier": {}}


def _is_one_of(path: Path, hashes: set[str]) -> bool:
    return path.is_file() and not path.is_symlink() and _hash(path.read_bytes()) in hashes


def _hash(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def list_differences(folder: Path, content: dict[str, str]) -> list[str]:
    """Return a line for each file of a folder that is missing, changed or not part of its
    content.
    """
    return [
        *(f"stray: {path.relative_to(folder)}" for path in list_strays(folder, content)),
        *list_changes(folder, content),
    ]


def list_changes(folder: Path, content: dict[str, str]) -> list[str]:
    """Return a line for each file of a folder that is missing or changed."""
    lines = []
    for name, text in sorted(content.items()):
        path = folder / name
        if not path.is_file():
            lines.append(f"missing: {name}")
        elif path.read_bytes() != text.encode():
            lines.append(f"changed: {name}")
    return lines


def list_strays(folder: Path, content: dict[str, str]) -> list[Path]:
    """Return the files of a folder, in order, that are not among its content; caches and the list
    are not counted.
    """
    files = (
        p
        for p in folder.rglob("*")
        if p.is_file() and "__pycache__" not in p.parts and p.name != LIST
    )
    return sorted(p for p in files if p.relative_to(folder).as_posix() not in content)
