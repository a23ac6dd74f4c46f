"""Commands of the command line in a process of their own: their progress is told, and they can be given up."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Coroutine, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Any

from planter import legible, workers
from planter.errors import ComputationError, PlanterError
from planter.studio.words import to_page_words

Send = Callable[[dict[str, Any]], Awaitable[None]]


class Process:
    """At most one work of a name for a page at a time: commands one after another."""

    def __init__(self, name: str, send: Send) -> None:
        self.name, self._send = name, send
        self._process: asyncio.subprocess.Process | None = None
        self._work: asyncio.Task[None] | None = None

    async def send(self, message: Mapping[str, Any]) -> None:
        """Send a message of this work."""
        await self._send({"work": self.name, **message})

    def begin(self, work: Coroutine[Any, Any, None]) -> None:
        """Do a work; the one before it is given up. The sentence of its error is sent."""
        self.cancel()
        self._work = asyncio.create_task(self._done(work))

    def cancel(self) -> None:
        """Give the work up."""
        if self._work is not None:
            self._work.cancel()
        if self._process is not None and self._process.returncode is None:
            self._process.terminate()
        self._process = self._work = None

    async def command(self, words: Sequence[str], labels: Mapping[str, str] = MappingProxyType({})) -> str:
        """What `planter WORDS` prints; its progress is sent line by line, files called by their `labels`.

        Raises ComputationError with the sentence of a command that does not succeed.
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
            raise ComputationError(last.removeprefix("planter: ") or f"{words[0]} was given up")
        return text.decode("utf-8")

    async def _done(self, work: Coroutine[Any, Any, None]) -> None:
        try:
            await work
        except PlanterError as error:
            await self.send({"error": error.message})
        except Exception as error:
            await self.send(
                {"error": legible.line(f"{self.name}: this cannot be done ({type(error).__name__}: {error})")}
            )


def _lines(text: str) -> Iterator[str]:
    """What is left of a text that writes over its own lines."""
    yield from (part for part in text.replace("\r", "\n").split("\n") if part.strip())
