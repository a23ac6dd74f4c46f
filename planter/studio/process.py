"""Commands in separate processes, whose progress a page displays and which it can cancel."""

from __future__ import annotations

import asyncio
import re
from collections.abc import Awaitable, Callable, Coroutine, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

from planter import safe_text, workers
from planter.errors import ComputationError, InputError, PlanterError
from planter.files.fields import SET
from planter.files.units import typeset_degrees
from planter.report.folder import NAME as LIST
from planter.report.folder import output_folder
from planter.text_files import is_file, read_json

Send = Callable[[dict[str, Any]], Awaitable[None]]
HINTS = {
    f" ({SET})": "",
    "rename it, choose another --out, or add --overwrite": "rename it, or move it elsewhere",
    "more --starts may": "more starts may",
    "ga: generation": "Genetic algorithm: generation",
    "limits: start": "Towards the limits: start",
    "ipopt again: start": "Local searches again: start",
    "ipopt: start": "Local searches: start",
    "polish: individual": "Last local searches: design",
    "pickup: round": "Moving the path: round",
}
"""Parts of messages that refer to the command line or to methods, and their replacements on a
page.
"""


def to_page_words(sentence: str, labels: Mapping[str, str]) -> str:
    """Return a message for a page, without references to the command line, and with `labels` for
    paths and keys.
    """
    for before, after in HINTS.items():
        sentence = sentence.replace(before, after)
    if labels:
        keys = "|".join(re.escape(key) for key in sorted(labels, key=len, reverse=True))
        sentence = re.sub(rf"(?<!\w)(?:{keys})(?!\w)", lambda match: labels[match[0]], sentence)
    return typeset_degrees(sentence)


def describe_error(error: Exception) -> str:
    """Return the message of an error of planter, or type and text of any other, as a line."""
    if isinstance(error, PlanterError):
        return error.message
    return safe_text.sanitise_line(f"this cannot be done ({type(error).__name__}: {error})")


SUMMARY = "summary.json"
"""File of a folder of results, which a search writes anew whenever it has a better design."""
LOOK_S = 0.25
"""Time between two looks at that file [s]."""


@dataclass(frozen=True)
class SearchEnding:
    """The end of a search: its last summary, None without any design, and why it has no result,
    empty if it has one.
    """

    summary: Mapping[str, Any] | None
    reason: str

    @classmethod
    def read(cls, summary: Mapping[str, Any] | None, stopped: bool, last_line: str) -> SearchEnding:
        """Return the end of a command from its summary and the last line of its progress."""
        if summary is not None and _has_result(summary):
            return cls(summary, "")
        return cls(summary, "The search was stopped." if stopped else last_line)


def _has_result(summary: Mapping[str, Any]) -> bool:
    return bool(summary.get("finished", True))


class StudioProcess:
    """A task of a page, such as a search or an export, which runs commands one after another."""

    def __init__(self, name: str, send: Send) -> None:
        self.name, self._send, self._is_stopped = name, send, False
        self._process: asyncio.subprocess.Process | None = None
        self._work: asyncio.Task[None] | None = None

    async def send(self, message: Mapping[str, Any]) -> None:
        """Send a message of this task."""
        await self._send({"work": self.name, **message})

    def begin(self, work: Callable[[], Coroutine[Any, Any, None]]) -> None:
        """Start a task after cancelling the previous one; if it fails, its error message is
        sent.
        """
        self.cancel()
        self._is_stopped = False
        self._work = asyncio.create_task(self._done(work))

    def cancel(self) -> None:
        """Cancel the task."""
        if self._work is not None:
            self._work.cancel()
        self._terminate()
        self._process = self._work = None

    def stop(self) -> None:
        """End the command, whose task goes on with what it has written."""
        self._is_stopped = True
        self._terminate()

    def _terminate(self) -> None:
        if self._process is not None and self._process.returncode is None:
            self._process.terminate()

    async def command(
        self, words: Sequence[str], labels: Mapping[str, str] = MappingProxyType({})
    ) -> str:
        """Run `planter WORDS` and return its output; its progress is sent line by line, with
        `labels` for paths.

        Raises ComputationError with the message of the command if it fails.
        """
        process = await self._start(words)
        assert process.stdout is not None
        answer = asyncio.create_task(process.stdout.read())
        last = await self._follow(process, labels)
        text = await answer
        if await process.wait():
            raise ComputationError(last or f"{words[0]} was cancelled")
        return text.decode("utf-8")

    async def search(
        self,
        words: Sequence[str],
        folder: Path,
        labels: Mapping[str, str],
        take: Callable[[Mapping[str, Any]], Awaitable[None]],
    ) -> SearchEnding:
        """Run a search `planter WORDS` that writes into a folder, and return its end.

        Its progress is sent line by line, and `take` gets its summary whenever it has a better
        design. The figures and the page of the folder are not waited for.
        """
        process = await self._start(words)
        if self._is_stopped:  # before there was a process
            process.terminate()
        watching = asyncio.create_task(self._watch(process, folder / SUMMARY, take))
        try:
            last = await self._follow(process, labels)
            await process.wait()
        finally:
            watching.cancel()
        return SearchEnding.read(_read_summary(folder / SUMMARY), self._is_stopped, last)

    async def _start(self, words: Sequence[str]) -> asyncio.subprocess.Process:
        self._process = await workers.start_async_program("planter", *words)
        return self._process

    async def _follow(self, process: asyncio.subprocess.Process, labels: Mapping[str, str]) -> str:
        """Send the progress of a process line by line until it ends, and return the last one."""
        assert process.stderr is not None
        last = ""
        while part := await process.stderr.read(4096):
            for line in _lines(part.decode("utf-8", "replace")):
                last = to_page_words(line, labels)
                await self.send({"progress": last})
        return last.removeprefix("planter: ")

    async def _watch(
        self,
        process: asyncio.subprocess.Process,
        file: Path,
        take: Callable[[Mapping[str, Any]], Awaitable[None]],
    ) -> None:
        """Hand over each summary that a process writes, and kill it after its result."""
        latest = None
        while True:
            await asyncio.sleep(LOOK_S)
            summary = _read_summary(file)
            if summary is None or summary == latest:
                continue
            latest = summary
            if _has_result(summary):
                process.kill()
                return
            with suppress(ComputationError):  # a design that cannot be displayed ends no search
                await take(summary)

    async def _done(self, work: Callable[[], Coroutine[Any, Any, None]]) -> None:
        try:
            await work()
        except Exception as error:
            await self.send({"error": describe_error(error)})


def _read_summary(file: Path) -> dict[str, Any] | None:
    """Return the content of a summary, None if there is none or it is being written."""
    try:
        return read_json(file) if is_file(file) else None
    except InputError:
        return None


def _lines(text: str) -> Iterator[str]:
    """Yield the lines of a text, including those that a carriage return overwrites."""
    yield from (part for part in text.replace("\r", "\n").split("\n") if part.strip())


FOLDER = "exports"
"""Folder for exports, below the folder of the studio."""


def export_path(folder: Path, *parts: str) -> Path:
    """Return a path for exports below the folder of a studio; `parts` are names and not paths.

    Raises InputError if a link leads out of the folder.
    """
    path = folder.joinpath(FOLDER, *(re.sub(r"[^\w-]+", "_", part) for part in parts))
    if not path.resolve().is_relative_to(folder.resolve()):
        raise InputError(
            f"{path}: a link leads out of the studio's folder {folder}; remove the link"
        )
    return path


def find_export(folder: Path, path: str) -> Path | None:
    """Return an exported file by its path below the exports, or None for any other path."""
    root = (folder / FOLDER).resolve()
    try:
        file = (root / path).resolve()
        inside = root.is_relative_to(folder.resolve()) and file.is_relative_to(root)
        return file if inside and file.is_file() else None
    except (OSError, ValueError):  # the name is not valid for a file
        return None


@dataclass(frozen=True)
class ExportTask:
    """An export: its name, the folder that it is written to, and the command that writes it."""

    name: str
    folder: Path
    command: Sequence[str]

    def state(self) -> dict[Path, tuple[int, int]]:
        """Return the files of the folder with time and number, which change if a file is written
        again.
        """
        files = (
            (path, path.stat())
            for path in self.folder.rglob("*")
            if path.is_file() and path.name != LIST
        )
        return {path: (stat.st_mtime_ns, stat.st_ino) for path, stat in files}

    def written_files(
        self, studio: Path, before: Mapping[Path, tuple[int, int]]
    ) -> list[dict[str, Any]]:
        """Return files written after the state `before`: paths below the exports of a studio, and
        sizes [byte].
        """
        files = sorted(path for path, marks in self.state().items() if before.get(path) != marks)
        root = studio / FOLDER
        return [
            {"path": path.relative_to(root).as_posix(), "bytes": path.stat().st_size}
            for path in files
        ]


async def export_file(process: StudioProcess, folder: Path, tasks: Sequence[ExportTask]) -> None:
    """Write exports, and send the files of each after it has been written.

    A command replaces files that it wrote before, and refuses to replace others.

    Raises ComputationError with the message of the first command that fails, and InputError if a
    folder cannot be written into.
    """
    await process.send({"exporting": ""})
    for task in tasks:
        output_folder(task.folder)
        await process.send({"exporting": task.name})
        before = task.state()
        await process.command(task.command)
        files = task.written_files(folder, before)
        await process.send(
            {"exported": task.name, "folder": str(task.folder.parent), "files": files}
        )
    await process.send({"exporting": None})
