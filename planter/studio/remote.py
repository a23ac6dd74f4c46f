"""A page's session in a process of its own, as the server has it: one request after another, replaced when it ends."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from planter.errors import ComputationError
from planter.studio.session import Message
from planter.studio.worker import DONE
from planter.studio.worker import __name__ as WORKER
from planter.workers import Worker, WorkerEndedError

LONGEST_S = 120.0
"""Time that an answer may take; what is compiled for the first time takes some ten seconds."""
GRACE_S = 1.0
"""Time that an answer may still take which nobody waits for any more."""
LONGEST_ANSWER = 2**27
"""Bytes of an answer."""
Request = Literal["seen", "finished", "checked", "details", "ends", "file", "wished", "search", "sought", "works"]


class GivenUpError(ComputationError):
    """An answer that nobody waits for any more."""


@dataclass(frozen=True)
class Answer:
    """The JSON object of an answer, and whether it is what was asked for rather than an error."""

    text: str
    done: bool

    def table(self) -> dict[str, Any]:
        """What stands in it. Raises ComputationError for an error."""
        found: dict[str, Any] = json.loads(self.text)
        if not self.done:
            raise ComputationError(found["error"])
        return found


class RemoteSession:
    """A session whose process starts with the first request, or before by `begin`."""

    def __init__(self, folder: Path, scratch: Path, explicit: Path | None = None) -> None:
        self._places = {"folder": str(folder), "scratch": str(scratch), "explicit": explicit and str(explicit)}
        self._process: Worker | None = None
        self._thread = ThreadPoolExecutor(1)
        self._opened: Message | None = None
        self._lock = asyncio.Lock()
        self._asked = 0
        self._busy = self._given_up = self._closed = False

    async def begin(self) -> None:
        """Start the process, so that the first request finds it ready."""
        async with self._lock:
            self._start()

    async def open(self, message: Message) -> Answer:
        """Open a machine. Raises ComputationError where the process ends."""
        async with self._lock:
            return await self._open(message)

    async def ask(self, what: Request, opening: Message, message: Message) -> Answer:
        """What a session answers of the machine that was opened so. Raises ComputationError where the process ends.

        Whoever waits may be cancelled: the process is asked the next thing when it has answered this one.
        """
        task = asyncio.create_task(self._ask(what, opening, message))
        task.add_done_callback(lambda done: done.cancelled() or done.exception())
        return await asyncio.shield(task)

    def interrupt(self) -> None:
        """Kill the process if what it is doing takes longer than the grace."""
        if self._busy:
            asyncio.get_running_loop().call_later(GRACE_S, self._kill_if_still_at, self._asked)

    async def close(self) -> None:
        """Kill the process, and wait for its end; no other is started."""
        self._closed = self._given_up = True
        if self._process is not None:
            await asyncio.to_thread(self._process.end)
        self._process = None
        self._thread.shutdown(wait=False)

    async def _ask(self, what: Request, opening: Message, message: Message) -> Answer:
        async with self._lock:
            if opening and (self._opened is not opening or self._process is None):
                answer = await self._open(opening)
                if not answer.done:
                    return answer
            return await self._exchange(what, message)

    async def _open(self, message: Message) -> Answer:
        answer = await self._exchange("open", message)
        if answer.done:
            self._opened = message
        return answer

    async def _exchange(self, what: str, message: Message) -> Answer:
        process = self._start()
        self._asked += 1
        self._busy, self._given_up = True, self._closed
        request, loop = _to_bytes({"do": what, "message": message}), asyncio.get_running_loop()
        try:
            text = (await loop.run_in_executor(self._thread, process.ask, request, LONGEST_S)).decode("ascii")
            return Answer(text[1:], text.startswith(DONE))
        except TimeoutError:
            self._process = None
            raise ComputationError(f"this was given up after {LONGEST_S:g} s") from None
        except WorkerEndedError:
            self._process = None
            if self._given_up:
                raise GivenUpError("this was given up") from None
            raise ComputationError(
                "the process that computes this machine has ended; the next change starts another"
            ) from None
        finally:
            self._busy = False

    def _start(self) -> Worker:
        if self._closed:
            raise GivenUpError("the page has been left")
        if self._process is None:
            self._opened = None
            self._process = Worker(WORKER, _to_bytes(self._places), LONGEST_ANSWER)
        return self._process

    def _kill_if_still_at(self, asked: int) -> None:
        if self._busy and self._asked == asked and self._process is not None:
            self._given_up = True
            self._process.kill()


def _to_bytes(content: Mapping[str, Any]) -> bytes:
    return json.dumps(content).encode("ascii")
