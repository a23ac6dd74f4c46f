"""A page's session in a process of its own, as the server has it: one request after another, replaced when it ends."""

from __future__ import annotations

import asyncio
import json
from asyncio.subprocess import Process
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from planter import workers
from planter.errors import ComputationError
from planter.studio.session import Message
from planter.studio.worker import DONE
from planter.studio.worker import __name__ as WORKER

LONGEST_S = 120.0
"""Time that an answer may take; what is compiled for the first time takes some ten seconds."""
GRACE_S = 1.0
"""Time that an answer may still take which nobody waits for any more."""
LONGEST_LINE = 2**27
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
        self._process: Process | None = None
        self._opened: Message | None = None
        self._lock = asyncio.Lock()
        self._asked = 0
        self._busy = self._given_up = self._closed = False

    async def begin(self) -> None:
        """Start the process, so that the first request finds it ready."""
        async with self._lock:
            await self._started()

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
        process = self._process
        self._kill()
        if process is not None:
            await process.wait()

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
        process = await self._started()
        assert process.stdin is not None
        assert process.stdout is not None
        self._asked += 1
        self._busy, self._given_up = True, self._closed
        line = b""
        try:
            async with asyncio.timeout(LONGEST_S):
                process.stdin.write(_line({"do": what, "message": message}))
                await process.stdin.drain()
                line = await process.stdout.readline()
        except TimeoutError:
            self._kill()
            raise ComputationError(f"this was given up after {LONGEST_S:g} s") from None
        except (OSError, ValueError):
            line = b""
        finally:
            self._busy = False
        if line.endswith(b"\n"):
            text = line.decode("ascii")
            return Answer(text[1:-1], text.startswith(DONE))
        self._kill()
        if self._given_up:
            raise GivenUpError("this was given up")
        raise ComputationError("the process that computes this machine has ended; the next change starts another")

    async def _started(self) -> Process:
        if self._closed:
            raise GivenUpError("the page has been left")
        if self._process is None:
            self._opened = None
            self._process = await workers.start_async_worker(WORKER, LONGEST_LINE, workers.ONE_THREAD)
            assert self._process.stdin is not None
            self._process.stdin.write(_line(self._places))
        return self._process

    def _kill_if_still_at(self, asked: int) -> None:
        if self._busy and self._asked == asked:
            self._given_up = True
            self._kill()

    def _kill(self) -> None:
        if self._process is not None and self._process.returncode is None:
            self._process.kill()
        self._process = None


def _line(content: Mapping[str, Any]) -> bytes:
    return json.dumps(content).encode("ascii") + b"\n"
