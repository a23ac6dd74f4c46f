"""The folder of a command's result: files whole or not at all, and a list of them for the next command.

By the list the next command removes what it does not write anew: no figure of another machine stays beside its own.
"""

from __future__ import annotations

import json
import os
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from contextvars import ContextVar
from functools import wraps
from pathlib import Path, PurePosixPath
from typing import ParamSpec, TypeVar

from planter.errors import InputError
from planter.files import text
from planter.report.folder_lock import lock_folder

NAME = ".planter.json"
LARGEST_LIST = 10_000_000
"""Bytes of a list, and files in it."""

P = ParamSpec("P")
T = TypeVar("T")


def output_folder(path: str | Path) -> Path:
    """The folder, made if it is not there, after a trial that files can be written into it.

    Raises InputError, naming the path, if not.
    """
    folder = Path(path)
    trial = folder / f".planter-{os.getpid()}-{threading.get_ident()}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        trial.touch(exist_ok=False)
        trial.unlink()
    except (OSError, ValueError) as error:
        raise _cannot_write(path, error) from None
    return folder


def write(path: Path, content: bytes) -> None:
    """Write a file at once and enter it in the list of its folder.

    Whoever looks sees the old content or the new, never a part. Raises InputError, naming the path, if it cannot be
    written, and as `check` for a file that planter did not write.
    """
    with replacing(path) as part:
        part.write_bytes(content)


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Within, a file too large for the memory is written under another name; in the end it is there, at once.

    An error leaves what was there. Raises InputError as `write`.
    """
    with _replacing(path) as part:
        yield part
        content = text.hash_file(part)
        _check(path, _manifest(path), content)
        _enter(path, content)


@contextmanager
def _replacing(path: Path) -> Iterator[Path]:
    part = path.with_name(f".{path.name[:100]}.{os.getpid()}-{threading.get_ident()}.part")
    try:
        try:
            yield part
            os.replace(part, path)
        finally:
            part.unlink(missing_ok=True)
    except (OSError, ValueError) as error:
        raise _cannot_write(path, error) from None


def _cannot_write(path: str | Path, error: OSError | ValueError) -> InputError:
    reason = (error.strerror if isinstance(error, OSError) else str(error)) or type(error).__name__
    return InputError(f"{path}: this cannot be written ({reason}), it must be in a folder that can")


def check(folder: str | Path, names: Iterable[str]) -> None:
    """Raise InputError for the first of some files in a folder that planter did not write, or that was edited since.

    None is refused within `overwriting(True)`.
    """
    manifest = _manifest(Path(folder) / NAME)
    for name in names:
        _check(Path(folder) / name, manifest)


@contextmanager
def overwriting(allowed: bool) -> Iterator[None]:
    """Within, files that planter did not write are replaced, too, if that is allowed."""
    token = _OVERWRITING.set(_OVERWRITING.get() or allowed)
    try:
        yield
    finally:
        _OVERWRITING.reset(token)


def is_overwriting() -> bool:
    """Whether files that planter did not write may be replaced."""
    return _OVERWRITING.get()


_OVERWRITING: ContextVar[bool] = ContextVar("overwriting", default=False)


def _check(path: Path, manifest: Manifest, content: str | None = None) -> None:
    """Raise InputError for a file of somebody else's, unless it has the content, by its hash, that is to be written."""
    if not os.path.lexists(path) or _OVERWRITING.get() or _is_as_written(path, content):
        return
    if not (manifest.wrote(path) or Manifest(path.parent).wrote(path)):
        raise InputError(
            f"{path}: planter did not write this file, or it was edited since, and it is not overwritten; rename it, "
            "choose another --out, or add --overwrite"
        )


def _manifest(path: Path) -> Manifest:
    """The list that a file belongs to: that of the folder that is being renewed, else that of its own."""
    manifest = _OPEN.get()
    return manifest if manifest is not None and manifest.holds(path) else Manifest(path.parent)


def _enter(path: Path, content: str) -> None:
    manifest = _manifest(path)
    manifest.enter(path, content, independent=manifest is not _OPEN.get())


class Manifest:
    """The files in a folder that planter wrote, each with a hash of its content; those that are `old` go at the end.

    A file that has been changed since, that this process has read, or that lies elsewhere by a link, is never touched.
    `independent` are those of commands that write single files: no other command removes them. `earlier` are hashes of
    the contents before, since a list is saved before its file: a kill between the two leaves none that is not known.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self.old, self.independent, self.earlier = _listed(folder)
        self.new: dict[str, str] = {}

    def holds(self, path: Path) -> bool:
        """Whether a file lies in the folder or below it."""
        return path.is_relative_to(self._folder)

    def wrote(self, path: Path) -> bool:
        """Whether planter wrote a file as it is."""
        name = path.relative_to(self._folder).as_posix()
        hashes = (part.get(name) for part in (self.new, self.old, self.independent, self.earlier))
        return _lies_inside(self._folder, name) and any(_is_as_written(path, one) for one in hashes)

    def enter(self, path: Path, content: str, independent: bool) -> None:
        """Enter a file that is about to be written, by the hash of its content."""
        name = path.relative_to(self._folder).as_posix()
        for part in (self.new, self.old, self.independent):
            if name in part:
                self.earlier[name] = part.pop(name)
        (self.independent if independent else self.new)[name] = content
        self._save()

    def keep(self, path: Path) -> None:
        """Leave a file of an earlier command where it is: this one goes on from it."""
        name = path.relative_to(self._folder).as_posix()
        if name in self.old:
            self.new[name] = self.old.pop(name)

    def clear(self) -> None:
        """Remove what earlier commands wrote and this one did not, and the folders that this leaves empty."""
        for name, content in self.old.items():
            path = self._folder / name
            if _is_as_written(path, content) and not text.was_read(path):
                with suppress(OSError):
                    path.unlink()
                    _drop_empty(path.parent, self._folder)
        self.old, self.earlier = {}, {}
        self._save()

    def _save(self) -> None:
        parts = {"files": self.old | self.new, "independent": self.independent, "earlier": self.earlier}
        listed = {part: dict(sorted(rows.items())) for part, rows in parts.items() if rows or part == "files"}
        with _replacing(self._folder / NAME) as part:
            part.write_bytes((json.dumps(listed, indent=1) + "\n").encode())


_OPEN: ContextVar[Manifest | None] = ContextVar("open manifest", default=None)


@contextmanager
def renewing(out: str | Path | None) -> Iterator[None]:
    """Within, what is written into a folder takes the place of what earlier commands wrote there.

    It is removed when all is written; an error leaves it, and the next command removes it. Nothing without a folder,
    and nothing more within another of these. Raises InputError if another process is writing into the folder.
    """
    if out is None or _OPEN.get() is not None:
        yield
        return
    with _owning(output_folder(out)) as folder:
        manifest = Manifest(folder)
        token = _OPEN.set(manifest)
        try:
            yield
            manifest.clear()
        finally:
            _OPEN.reset(token)


@contextmanager
def _owning(folder: Path) -> Iterator[Path]:
    with ExitStack() as owned:
        try:
            owned.enter_context(lock_folder(folder))
        except OSError as error:
            raise _cannot_write(folder, error) from None
        yield folder


def renews(write: Callable[P, T]) -> Callable[P, T]:
    """Decorator for a function whose first argument is the folder that it writes a command's result into."""

    @wraps(write)
    def renewed(*args: P.args, **kwargs: P.kwargs) -> T:
        out = args[0]
        assert isinstance(out, str | Path)
        with renewing(out):
            return write(*args, **kwargs)

    return renewed


def keep(path: Path) -> None:
    """Leave a file of an earlier command, where a folder is being renewed: this command goes on from it."""
    manifest = _OPEN.get()
    if manifest is not None and manifest.holds(path):
        manifest.keep(path)


def _listed(folder: Path) -> list[dict[str, str]]:
    """Names and hashes of each part of a folder's list; what is no such list, or leads out of it, does not count."""
    try:
        found = text.read_json(folder / NAME, LARGEST_LIST, LARGEST_LIST)
        parts = [found["files"], found.get("independent", {}), found.get("earlier", {})]
        rows = [{str(name): str(content) for name, content in part.items()} for part in parts]
    except (InputError, KeyError, AttributeError):
        return [{}, {}, {}]
    return [{name: content for name, content in part.items() if _lies_inside(folder, name)} for part in rows]


def _lies_inside(folder: Path, name: str) -> bool:
    parts = PurePosixPath(name).parts
    if not parts or ".." in parts or PurePosixPath(name).is_absolute() or "\0" in name:
        return False
    return not any((folder / Path(*parts[:count])).is_symlink() for count in range(1, len(parts) + 1))


def _drop_empty(inner: Path, folder: Path) -> None:
    while inner != folder and not any(inner.iterdir()):
        inner.rmdir()
        inner = inner.parent


def _is_as_written(path: Path, content: str | None) -> bool:
    try:
        return content is not None and not path.is_symlink() and text.hash_file(path) == content
    except InputError:
        return False
