"""The folder of a command's result: files whole or not at all, and a list of them for the next command.

By the list the next command removes what it does not write anew: no figure of another machine stays beside its own.
"""

from __future__ import annotations

import hashlib
import json
import os
import threading
from collections.abc import Callable, Iterator
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
        trial.touch()
        trial.unlink()
    except (OSError, ValueError) as error:
        raise _cannot_write(path, error) from None
    return folder


def replace(path: Path, content: bytes) -> None:
    """Writes a file at once: whoever looks finds the old content or the new, never a part.

    Raises InputError, naming the path, if it cannot be written.
    """
    part = _part(path)
    try:
        try:
            part.write_bytes(content)
            os.replace(part, path)
        finally:
            part.unlink(missing_ok=True)
    except (OSError, ValueError) as error:
        raise _cannot_write(path, error) from None


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Within, a file too large for the memory is written under another name; in the end it is there, at once.

    An error leaves what was there. Raises InputError, naming the path, if it cannot be written.
    """
    part = _part(path)
    try:
        try:
            yield part
            os.replace(part, path)
        finally:
            part.unlink(missing_ok=True)
    except (OSError, ValueError) as error:
        raise _cannot_write(path, error) from None
    _entered(path, text.hash_file(path))


def _part(path: Path) -> Path:
    return path.with_name(f".{path.name}.{os.getpid()}-{threading.get_ident()}.part")


def _cannot_write(path: str | Path, error: OSError | ValueError) -> InputError:
    reason = (error.strerror if isinstance(error, OSError) else str(error)) or type(error).__name__
    return InputError(f"{path}: this cannot be written ({reason}), it must be in a folder that can")


class Manifest:
    """The files in a folder that commands wrote, each with a hash of its content; those that are `old` go at the end.

    A file that has been changed since, that this process has read, or that lies elsewhere by a link, is never touched.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self.old = _listed(folder)
        self.new: dict[str, str] = {}

    def holds(self, path: Path) -> bool:
        """Whether a file lies in the folder or below it."""
        return path.is_relative_to(self._folder)

    def renew(self, path: Path, content: str) -> None:
        """Enter a file that has just been written, by the hash of its content."""
        name = path.relative_to(self._folder).as_posix()
        self.old.pop(name, None)
        self.new[name] = content
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
        self.old = {}
        self._save()

    def _save(self) -> None:
        listed = {"files": dict(sorted((self.old | self.new).items()))}
        replace(self._folder / NAME, (json.dumps(listed, indent=1) + "\n").encode())


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


def written(path: Path, content: bytes) -> None:
    """Enter a file that has just been written, where a folder is being renewed and it lies there."""
    _entered(path, _hash(content))


def _entered(path: Path, content: str) -> None:
    manifest = _OPEN.get()
    if manifest is not None and manifest.holds(path):
        manifest.renew(path, content)


def keep(path: Path) -> None:
    """Leave a file of an earlier command, where a folder is being renewed: this command goes on from it."""
    manifest = _OPEN.get()
    if manifest is not None and manifest.holds(path):
        manifest.keep(path)


def _listed(folder: Path) -> dict[str, str]:
    """Names and hashes of a folder's list; what is not such a list, or leads out of the folder, does not count."""
    try:
        found = text.read_json(folder / NAME, LARGEST_LIST, LARGEST_LIST)["files"]
        rows = {str(name): str(content) for name, content in found.items()}
    except (InputError, KeyError, AttributeError):
        return {}
    return {name: content for name, content in rows.items() if _lies_inside(folder, name)}


def _lies_inside(folder: Path, name: str) -> bool:
    parts = PurePosixPath(name).parts
    if not parts or ".." in parts or PurePosixPath(name).is_absolute() or "\0" in name:
        return False
    return not any((folder / Path(*parts[:count])).is_symlink() for count in range(1, len(parts) + 1))


def _drop_empty(inner: Path, folder: Path) -> None:
    while inner != folder and not any(inner.iterdir()):
        inner.rmdir()
        inner = inner.parent


def _is_as_written(path: Path, content: str) -> bool:
    try:
        return text.hash_file(path) == content
    except InputError:
        return False


def _hash(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()
