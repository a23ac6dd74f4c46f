"""Commands in separate processes, whose progress a page displays and which it can cancel."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Coroutine, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Any

from planter import safe_text, workers
from planter.errors import ComputationError, PlanterError
from planter.files.fields import SET

Send = Callable[[dict[str, Any]], Awaitable[None]]
HINTS = {
    f" ({SET})": "",
    "rename it, choose another --out, or add --overwrite": "rename it, or move it elsewhere",
}
"""Parts of messages that refer to the command line, and their replacements on a page."""


def to_page_words(sentence: str, labels: Mapping[str, str]) -> str:
    """Return a message for a page, without references to the command line, and with `labels` for paths of files."""
    for before, after in {**labels, **HINTS}.items():
        sentence = sentence.replace(before, after)
    return sentence


class Process:
    """A task of a page, such as a search or an export, which runs commands one after another."""

    def __init__(self, name: str, send: Send) -> None:
        self.name, self._send = name, send
        self._process: asyncio.subprocess.Process | None = None
        self._work: asyncio.Task[None] | None = None

    async def send(self, message: Mapping[str, Any]) -> None:
        """Send a message of this task."""
        await self._send({"work": self.name, **message})

    def begin(self, work: Coroutine[Any, Any, None]) -> None:
        """Start a task after cancelling the previous one; if it fails, its error message is sent."""
        self.cancel()
        self._work = asyncio.create_task(self._done(work))

    def cancel(self) -> None:
        """Cancel the task."""
        if self._work is not None:
            self._work.cancel()
        if self._process is not None and self._process.returncode is None:
            self._process.terminate()
        self._process = self._work = None

    async def command(self, words: Sequence[str], labels: Mapping[str, str] = MappingProxyType({})) -> str:
        """Run `planter WORDS` and return its output; its progress is sent line by line, with `labels` for paths.

        Raises ComputationError with the message of the command if it fails.
        """
        process = self._process = await workers.start_async_program("planter", *words)
        assert process.stdout is not None
        assert process.stderr is not None
        answer = asyncio.create_task(process.stdout.read())
        last = ""
        while part := await process.stderr.read(4096):
            for line in _lines(part.decode("utf-8", "replace")):
                last = to_page_words(line, labels)
                await self.send({"progress": last})
        text = await answer
        if await process.wait():
            raise ComputationError(last.removeprefix("planter: ") or f"{words[0]} was cancelled")
        return text.decode("utf-8")

    async def _done(self, work: Coroutine[Any, Any, None]) -> None:
        try:
            await work
        except PlanterError as error:
            await self.send({"error": error.message})
        except Exception as error:
            await self.send(
                {
                    "error": safe_text.sanitise_line(
                        f"{self.name}: this cannot be done ({type(error).__name__}: {error})"
                    )
                }
            )


def _lines(text: str) -> Iterator[str]:
    """Yield the lines of a text, including those that a carriage return overwrites."""
    yield from (part for part in text.replace("\r", "\n").split("\n") if part.strip())
