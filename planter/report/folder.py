"""The output folder of a command: files that are replaced at once, and a manifest of them.

The next command removes files of the manifest that it does not write itself, so that no figure of
an earlier machine remains.
"""

from __future__ import annotations

import errno
import json
import os
import sys
import threading
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from contextvars import ContextVar
from functools import wraps
from pathlib import Path, PurePosixPath
from typing import ParamSpec, TypeVar

from planter import text_files
from planter.errors import InputError

LOCK_NAME = ".planter.lock"
"""The locked file, which contains the number of the owning process; it is removed when the lock is
released.
"""
_TAKEN = {errno.EACCES, errno.EAGAIN, errno.EWOULDBLOCK, errno.EDEADLK}
_UNSUPPORTED = {errno.ENOSYS, errno.EOPNOTSUPP, errno.ENOLCK}

if sys.platform == "win32":
    import msvcrt

    _LOCKED_BYTE = 1 << 30
    """Offset far behind the content, because Windows lets no process read locked bytes."""

    def _lock(file: int) -> None:
        os.lseek(file, _LOCKED_BYTE, os.SEEK_SET)
        try:
            msvcrt.locking(file, msvcrt.LK_NBLCK, 1)
        finally:
            os.lseek(file, 0, os.SEEK_SET)

    def _release(path: Path, file: int) -> None:
        os.close(file)
        with suppress(OSError):  # another process has opened the file and owns it now
            path.unlink()
else:
    import fcntl

    def _lock(file: int) -> None:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)

    def _release(path: Path, file: int) -> None:
        with suppress(
            OSError
        ):  # name first, lock second: a process that has opened the file sees its removal
            path.unlink()
        os.close(file)


@contextmanager
def lock_folder(folder: Path) -> Iterator[None]:
    """Lock a folder, within the context, against other processes and other threads; the lock ends
    with its process.

    A warning is issued if the file system has no locks. Raises InputError, naming folder and
    process, if the folder is locked, and OSError if the lock file cannot be created.
    """
    path = folder / LOCK_NAME
    file = _open_locked(path)
    try:
        os.ftruncate(file, 0)
        os.lseek(file, 0, os.SEEK_SET)
        os.write(file, f"{os.getpid()}\n".encode())
        yield
    finally:
        _release(path, file)


def _open_locked(path: Path) -> int:
    """Return a descriptor of the locked file; a file that its last owner has just removed is
    created again.
    """
    while True:
        file = os.open(path, os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0), 0o666)
        try:
            _take(path, file)
            if os.fstat(file).st_nlink:
                return file
        except BaseException:
            os.close(file)
            raise
        os.close(file)


def _take(path: Path, file: int) -> None:
    """Lock a file. Raises InputError if another process owns it, or if planter did not write it."""
    error_number = 0
    try:
        _lock(file)
    except OSError as error:
        if error.errno not in _TAKEN | _UNSUPPORTED:
            raise
        error_number = error.errno or 0
    content = os.read(file, 32).decode(errors="replace").strip()
    if error_number in _TAKEN:
        process = f"process {content}" if content.isdigit() else "another process"
        allowed = "wait until it has ended, or choose another --out"
        raise InputError(f"{path.parent}: {process} is writing into this folder; {allowed}")
    if content and not content.isdigit():
        raise InputError(
            f"{path}: planter did not write this file and does not overwrite it; remove it, or "
            f"choose another --out"
        )
    if error_number in _UNSUPPORTED:
        warning = (
            f"{path.parent}: this file system has no locks; run one command at a time on "
            f"this folder"
        )
        warnings.warn(warning, RuntimeWarning, stacklevel=2)


NAME = ".planter.json"
LARGEST_LIST = 10_000_000
"""Maximum size of a manifest [byte], and maximum number of its files."""

P = ParamSpec("P")
T = TypeVar("T")


def output_folder(path: str | Path) -> Path:
    """Create a folder if necessary, and check that files can be written into it.

    Raises InputError, naming the path, if they cannot.
    """
    folder = Path(path)
    trial = folder / f".planter-{os.getpid()}-{threading.get_ident()}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        trial.touch(exist_ok=False)
        trial.unlink()
    except FileExistsError:
        raise InputError(f"{path}: this is a file, but results are written to a folder") from None
    except (OSError, ValueError) as error:
        raise _cannot_write(path, error) from None
    return folder


def write_file(path: Path, content: bytes) -> None:
    """Write a file and enter it in the manifest of its folder.

    Readers see the old content or the new, never a part. Raises InputError, naming the path, if it
    cannot be written, and as `check_files` does if it would replace a file that planter did not
    write.
    """
    with replace_file(path) as part:
        part.write_bytes(content)


def create_file(path: Path, content: bytes) -> None:
    """Create a file that is its user's from the beginning: no manifest has it.

    Raises InputError, naming the path, if the file exists or cannot be written.
    """
    try:
        with path.open("xb") as file:
            file.write(content)
    except FileExistsError:
        raise InputError(f"{path}: this file exists, and it is not overwritten") from None
    except (OSError, ValueError) as error:
        raise _cannot_write(path, error) from None


def drop_file(path: Path) -> None:
    """Remove a file that planter wrote, if it is there as it was written."""
    manifest = _manifest(path)
    if manifest.wrote(path):
        path.unlink(missing_ok=True)
        manifest.forget(path)


@contextmanager
def replace_file(path: Path) -> Iterator[Path]:
    """Yield a temporary path for a file too large for memory, and rename it to `path` at the end.

    An error leaves the previous file. Raises InputError as `write_file` does.
    """
    with _replacing(path) as part:
        yield part
        content, manifest = text_files.hash_file(part), _manifest(path)
        _check(path, manifest, content)
        manifest.enter(path, content, independent=manifest is not _OPEN.get())


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


def check_files(folder: str | Path, names: Iterable[str]) -> None:
    """Raise InputError for the first of some files that planter did not write, or that was edited
    since.

    No file is refused within `allow_overwriting(True)`.
    """
    manifest = _manifest(Path(folder) / NAME)
    for name in names:
        _check(Path(folder) / name, manifest)


@contextmanager
def allow_overwriting(allowed: bool) -> Iterator[None]:
    """Allow, within the context, that files which planter did not write are replaced."""
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
    """Raise InputError if planter did not write the file and its content differs from the hash
    `content`.
    """
    if not os.path.lexists(path) or _OVERWRITING.get() or _is_as_written(path, content):
        return
    if not (manifest.wrote(path) or Manifest(path.parent).wrote(path)):
        raise InputError(
            f"{path}: planter did not write this file, or it was edited since, and it is not "
            f"overwritten; rename it, "
            "choose another --out, or add --overwrite"
        )


def _manifest(path: Path) -> Manifest:
    """Return the manifest of a file: that of the folder being renewed, or else that of its parent
    folder.
    """
    manifest = _OPEN.get()
    return manifest if manifest is not None and manifest.holds(path) else Manifest(path.parent)


class Manifest:
    """The files in a folder that planter wrote, each with a hash of its content; `old` files are
    removed at the end.

    A file that was edited since, that this process has read, or that a link leads to is never
    removed. `independent` are files of commands that write single files; no other command removes
    them. `earlier` are hashes of the previous contents: a manifest is saved before its file, so
    that a kill between the two leaves no unlisted file.
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
        return _lies_inside(self._folder, name) and any(
            _is_as_written(path, content) for content in hashes
        )

    def enter(self, path: Path, content: str, independent: bool) -> None:
        """Enter a file that is about to be written, with the hash of its content."""
        name = path.relative_to(self._folder).as_posix()
        for part in (self.new, self.old, self.independent):
            if name in part:
                self.earlier[name] = part.pop(name)
        (self.independent if independent else self.new)[name] = content
        self._save()

    def forget(self, path: Path) -> None:
        """Remove a file from all lists."""
        name = path.relative_to(self._folder).as_posix()
        for part in (self.new, self.old, self.independent, self.earlier):
            part.pop(name, None)
        self._save()

    def keep(self, path: Path) -> None:
        """Keep a file of an earlier command, which this command continues."""
        name = path.relative_to(self._folder).as_posix()
        if name in self.old:
            self.new[name] = self.old.pop(name)

    def clear(self) -> None:
        """Remove files that earlier commands wrote and this one did not, and folders that become
        empty.
        """
        for name, content in self.old.items():
            path = self._folder / name
            if _is_as_written(path, content) and not text_files.was_read(path):
                with suppress(OSError):
                    path.unlink()
                    _drop_empty(path.parent, self._folder)
        self.old, self.earlier = {}, {}
        self._save()

    def _save(self) -> None:
        parts = {
            "files": self.old | self.new,
            "independent": self.independent,
            "earlier": self.earlier,
        }
        listed = {
            part: dict(sorted(rows.items()))
            for part, rows in parts.items()
            if rows or part == "files"
        }
        with _replacing(self._folder / NAME) as part:
            part.write_bytes((json.dumps(listed, indent=1) + "\n").encode())


_OPEN: ContextVar[Manifest | None] = ContextVar("open manifest", default=None)


@contextmanager
def renew_files(out: str | Path | None) -> Iterator[None]:
    """Replace, within the context, the files that earlier commands wrote into a folder.

    They are removed at the end; after an error they remain until the next command. Nothing is
    replaced if `out` is None, and an inner context leaves the removal to the outer. Raises
    InputError if another process is writing there.
    """
    if out is None or _OPEN.get() is not None:
        yield
        return
    folder = output_folder(out)
    with ExitStack() as owned:
        try:
            owned.enter_context(lock_folder(folder))
        except OSError as error:
            raise _cannot_write(folder, error) from None
        manifest = Manifest(folder)
        token = _OPEN.set(manifest)
        try:
            yield
            manifest.clear()
        finally:
            _OPEN.reset(token)


def renews_files(write: Callable[P, T]) -> Callable[P, T]:
    """Decorate a function that writes the result of a command into the folder of its first
    argument.
    """

    @wraps(write)
    def renewed(*args: P.args, **kwargs: P.kwargs) -> T:
        out = args[0]
        assert isinstance(out, str | Path)
        with renew_files(out):
            return write(*args, **kwargs)

    return renewed


def keep_file(path: Path) -> None:
    """Keep a file of an earlier command in a folder that is being renewed, because this command
    continues it.
    """
    manifest = _OPEN.get()
    if manifest is not None and manifest.holds(path):
        manifest.keep(path)


def _listed(folder: Path) -> list[dict[str, str]]:
    """Return names and hashes of each part of a manifest, without invalid parts and files outside
    the folder.
    """
    try:
        table = text_files.read_json(folder / NAME, LARGEST_LIST, LARGEST_LIST)
        parts = [table["files"], table.get("independent", {}), table.get("earlier", {})]
        rows = [{str(name): str(content) for name, content in part.items()} for part in parts]
    except (InputError, KeyError, AttributeError):
        return [{}, {}, {}]
    return [
        {name: content for name, content in part.items() if _lies_inside(folder, name)}
        for part in rows
    ]


def _lies_inside(folder: Path, name: str) -> bool:
    parts = PurePosixPath(name).parts
    if not parts or ".." in parts or PurePosixPath(name).is_absolute() or "\0" in name:
        return False
    return not any(
        (folder / Path(*parts[:count])).is_symlink() for count in range(1, len(parts) + 1)
    )


def _drop_empty(inner: Path, folder: Path) -> None:
    while inner != folder and not any(inner.iterdir()):
        inner.rmdir()
        inner = inner.parent


def _is_as_written(path: Path, content: str | None) -> bool:
    try:
        return (
            content is not None and not path.is_symlink() and text_files.hash_file(path) == content
        )
    except InputError:
        return False
