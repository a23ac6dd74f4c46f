"""A page's session in a separate process, which answers one request after another and is replaced when it ends."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from planter.errors import ComputationError
from planter.studio.session import DONE, Message
from planter.studio.session import __name__ as WORKER
from planter.workers import Worker, WorkerEndedError

LONGEST_S = 120.0
"""Maximum time of an answer [s]; the first compilation takes about ten seconds."""
GRACE_S = 1.0
"""Maximum remaining time of an answer that is no longer needed [s]."""
LONGEST_ANSWER = 2**27
"""Maximum size of an answer [byte]."""
Request = Literal["seen", "finished", "checked", "details", "ends", "file", "wished", "search", "sought", "works"]


class GivenUpError(ComputationError):
    """A request was cancelled because its answer is no longer needed."""


@dataclass(frozen=True)
class Answer:
    """The JSON object of an answer, and whether it is a result rather than an error."""

    text: str
    done: bool

    def table(self) -> dict[str, Any]:
        """Return the JSON object. Raises ComputationError if it is an error."""
        table: dict[str, Any] = json.loads(self.text)
        if not self.done:
            raise ComputationError(table["error"])
        return table


class RemoteSession:
    """A session whose process starts with the first request, or earlier by `begin`."""

    def __init__(self, folder: Path, scratch: Path, explicit: Path | None = None) -> None:
        self._places = {"folder": str(folder), "scratch": str(scratch), "explicit": explicit and str(explicit)}
        self._process: Worker | None = None
        self._thread = ThreadPoolExecutor(1)
        self._opened: Message | None = None
        self._lock = asyncio.Lock()
        self._request_count = 0
        self._busy = self._given_up = self._closed = False

    async def begin(self) -> None:
        """Start the process in advance of the first request."""
        async with self._lock:
            self._start()

    async def open(self, message: Message) -> Answer:
        """Open a machine. Raises ComputationError if the process ends."""
        async with self._lock:
            return await self._open(message)

    async def ask(self, request: Request, opening: Message, message: Message) -> Answer:
        """Return the answer to a request on the machine opened by `opening`.

        If the caller is cancelled, the process still completes this request before the next. Raises ComputationError
        if the process ends.
        """
        task = asyncio.create_task(self._ask(request, opening, message))
        task.add_done_callback(lambda done: done.cancelled() or done.exception())
        return await asyncio.shield(task)

    def interrupt(self) -> None:
        """Kill the process if its present request takes longer than the grace time."""
        if self._busy:
            asyncio.get_running_loop().call_later(GRACE_S, self._kill_if_still_at, self._request_count)

    async def close(self) -> None:
        """Kill the process and wait for its end; no other is started."""
        self._closed = self._given_up = True
        if self._process is not None:
            await asyncio.to_thread(self._process.end)
        self._process = None
        self._thread.shutdown(wait=False)

    async def _ask(self, request: Request, opening: Message, message: Message) -> Answer:
        async with self._lock:
            if opening and (self._opened is not opening or self._process is None):
                answer = await self._open(opening)
                if not answer.done:
                    return answer
            return await self._exchange(request, message)

    async def _open(self, message: Message) -> Answer:
        answer = await self._exchange("open", message)
        if answer.done:
            self._opened = message
        return answer

    async def _exchange(self, request: str, message: Message) -> Answer:
        process = self._start()
        self._request_count += 1
        self._busy, self._given_up = True, self._closed
        content, loop = _to_bytes({"do": request, "message": message}), asyncio.get_running_loop()
        try:
            text = (await loop.run_in_executor(self._thread, process.ask, content, LONGEST_S)).decode("ascii")
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

    def _kill_if_still_at(self, count: int) -> None:
        if self._busy and self._request_count == count and self._process is not None:
            self._given_up = True
            self._process.kill()


def _to_bytes(content: Mapping[str, Any]) -> bytes:
    return json.dumps(content).encode("ascii")
