"""The WebSocket connection of a page: only its newest request is computed, and slow results follow
when it pauses.
"""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable, Coroutine, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from starlette.websockets import WebSocket, WebSocketDisconnect

from planter import safe_text
from planter.errors import ComputationError, InputError
from planter.studio.process import ExportTask, StudioProcess, describe_error, export_file
from planter.studio.session import FAILED, Message, list_sources
from planter.studio.session import __name__ as WORKER
from planter.text_files import LIMIT_BYTES, parse_json
from planter.workers import Worker, WorkerEndedError

LONGEST_S = 120.0
"""Maximum time of an answer [s]; the first compilation takes about ten seconds."""
GRACE_S = 1.0
"""Maximum remaining time of an answer that is no longer needed [s]."""
LONGEST_ANSWER = 2**27
"""Maximum size of an answer [byte]."""
Task = Callable[[], Coroutine[Any, Any, Any]]
"""Makes the coroutine of a task."""


class GivenUpError(ComputationError):
    """A request was cancelled because its answer is no longer needed."""


@dataclass(frozen=True)
class StudioAnswer:
    """The JSON object of an answer."""

    text: str

    @property
    def done(self) -> bool:
        """Whether it is a result rather than an error."""
        return not self.text.startswith(FAILED)

    def table(self) -> dict[str, Any]:
        """Return the JSON object. Raises ComputationError if it is an error."""
        table: dict[str, Any] = json.loads(self.text)
        if not self.done:
            raise ComputationError(table["error"])
        return table


class RemoteSession:
    """A session whose process starts with the first request, or earlier by `start`, and opens
    `machine` in advance.
    """

    def __init__(
        self, folder: Path, scratch: Path, explicit: Path | None = None, machine: str | None = None
    ) -> None:
        self._places = {
            "machine": machine,
            "folder": str(folder),
            "scratch": str(scratch),
            "explicit": explicit and str(explicit),
        }
        self._process: Worker | None = None
        self._thread = ThreadPoolExecutor(1)
        self._opened: Message | None = None
        self._lock = asyncio.Lock()
        self._request_count = 0
        self._busy = self._given_up = self._closed = False

    async def open(self, message: Message) -> StudioAnswer:
        """Open a machine. Raises ComputationError if the process ends."""
        async with self._lock:
            return await self._open(message)

    async def ask(self, request: str, opening: Message, message: Message) -> StudioAnswer:
        """Return the answer to a request on the machine opened by `opening`.

        If the caller is cancelled, the process still completes this request before the next. Raises
        ComputationError if the process ends.
        """
        task = asyncio.create_task(self._ask(request, opening, message))
        task.add_done_callback(lambda done: done.cancelled() or done.exception())
        return await asyncio.shield(task)

    def interrupt(self) -> None:
        """Kill the process if its present request takes longer than the grace time."""
        if self._busy:
            asyncio.get_running_loop().call_later(
                GRACE_S, self._kill_if_still_at, self._request_count
            )

    async def close(self) -> None:
        """Kill the process and wait for its end; no other is started."""
        self._closed = self._given_up = True
        if self._process is not None:
            await asyncio.to_thread(self._process.end)
        self._process = None
        self._thread.shutdown(wait=False)

    async def _ask(self, request: str, opening: Message, message: Message) -> StudioAnswer:
        async with self._lock:
            if opening and (self._opened is not opening or self._process is None):
                answer = await self._open(opening)
                if not answer.done:
                    return answer
            return await self._exchange(request, message)

    async def _open(self, message: Message) -> StudioAnswer:
        answer = await self._exchange("open", message)
        if answer.done:
            self._opened = message
        return answer

    async def _exchange(self, request: str, message: Message) -> StudioAnswer:
        process = self.start()
        self._request_count += 1
        self._busy, self._given_up = True, self._closed
        content, loop = _to_bytes({"do": request, "message": message}), asyncio.get_running_loop()
        try:
            answer = await loop.run_in_executor(self._thread, process.ask, content, LONGEST_S)
            return StudioAnswer(answer.decode("ascii"))
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

    def start(self) -> Worker:
        """Return the process, which is started unless it runs. Raises GivenUpError after the end."""
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


PAUSES: Mapping[str, float] = {
    "checked": 0.1,
    "finished": 0.0,
    "details": 0.4,
    "ends": 0.1,
}
"""Requests that are computed when the user pauses, with the additional pause before each [s]."""
REFINEMENTS = ("refine_first", "refine")
"""Requests that are computed at once when there is no newer one."""
LONGEST_MESSAGE = 2 * LIMIT_BYTES
"""Maximum characters of a message: those of a file, in which JSON may escape each by two."""
ANSWERED: Mapping[str, str] = {
    "file": "file",
    "wish": "wished",
    "plan": "plan",
    "design": "design",
}
"""Requests that are answered immediately, by the `ask` of a message."""


class Live:
    """The connection of a page with two processes: one follows the user, and one computes slow
    results.
    """

    def __init__(
        self, folder: Path, explicit: Path | None = None, machine: str | None = None
    ) -> None:
        self.folder = folder.resolve()
        self._scratch = TemporaryDirectory(prefix="planter-", ignore_cleanup_errors=True)
        self.front, self.background = (
            RemoteSession(self.folder, Path(self._scratch.name, name), explicit, first)
            for name, first in (("front", machine), ("background", None))
        )
        self.search, self.export = (
            StudioProcess("search", self._send),
            StudioProcess("export", self._send),
        )
        self._to_open: Message | None = None
        self._newest: Message | None = None
        self._opening: Message = {}
        self._requested = asyncio.Event()
        self._details: asyncio.Task[None] | None = None
        self._tasks: set[asyncio.Task[None]] = set()

    async def run(self, socket: WebSocket) -> None:
        """Serve the page until it disconnects."""
        self.socket = socket
        self.front.start()
        await self.socket.accept()
        await self._send({"sources": list_sources(self.folder)})
        self._begin(self._follow)
        try:
            while True:
                try:
                    await self._take(await self._receive())
                except InputError as error:
                    await self._send({"error": describe_error(error)})
        except WebSocketDisconnect:
            pass
        finally:
            self._cancel_details()
            for task in self._tasks:
                task.cancel()
            self.search.cancel()
            self.export.cancel()
            await self.front.close()
            await self.background.close()
            self._scratch.cleanup()

    async def _receive(self) -> Message:
        """Return the next message.

        Raises InputError if it is not a JSON object, or if it is too large.
        """
        try:
            return parse_json(await self.socket.receive_text(), "the message", LONGEST_MESSAGE)
        except KeyError:
            raise InputError("the message must be text") from None

    async def _take(self, message: Message) -> None:
        if "values" in message and "ask" not in message:
            self._newest = message
            self._requested.set()
        elif message.get("ask") == "stop":
            self.search.stop()
        elif message.get("ask") == "cancel":
            self.export.cancel()
        elif message.get("ask") == "open":
            self._to_open, self._newest = message, None
            self._requested.set()
            self._cancel_details()
            self.search.cancel()
            self.front.interrupt()
            self.background.interrupt()
        else:
            await self._answer(message)

    async def _answer(self, message: Message) -> None:
        ask = message.get("ask")
        if ask == "optimise":
            self.search.begin(partial(self._search, message))
        elif ask == "export":
            self.export.begin(partial(self._export, message))
        elif isinstance(ask, str) and ask in ANSWERED:
            request = partial(self.front.ask, ANSWERED[ask], self._opening, message)
            self._begin(partial(self._send_answer, request))
        else:
            await self._send(
                {"error": f"ask = {safe_text.format_value(ask)}: there is no such request"}
            )

    def _begin(self, task: Task) -> None:
        """Start a task in the background; an exception becomes an error message.

        A coroutine is made where it is awaited: one that is handed over stays behind where a page
        closes before.
        """
        running = asyncio.create_task(self._guarded(task))
        self._tasks.add(running)
        running.add_done_callback(self._tasks.discard)

    async def _guarded(self, task: Task) -> None:
        try:
            await task()
        except Exception as error:
            await self._send({"error": describe_error(error)})

    async def _search(self, message: Message) -> None:
        machine = self._opening
        task = (await self.front.ask("search", machine, message)).table()
        await self.search.send({"searching": {key: task[key] for key in ("goal", "starts")}})

        async def read_design(table: Mapping[str, Any]) -> dict[str, Any]:
            request = {"answer": table, "locked": message.get("locked")}
            return (await self.front.ask("sought", machine, request)).table()

        async def hand_over(table: Mapping[str, Any]) -> None:
            await self.search.send({"best": await read_design(table)})

        ending = await self.search.search(
            task["command"], Path(task["out"]), task["labels"], hand_over
        )
        if ending.summary is None:
            raise ComputationError(ending.reason)
        design = await read_design(ending.summary)
        await self.search.send({"optimum": design, "reason": ending.reason})

    async def _export(self, message: Message) -> None:
        answer = (await self.front.ask("works", self._opening, message)).table()
        tasks = [
            ExportTask(work["name"], Path(work["folder"]), work["command"])
            for work in answer["works"]
        ]
        await export_file(self.export, self.folder, tasks)

    async def _follow(self) -> None:
        """Compute the newest request, and slow results after a pause without newer ones."""
        while True:
            await self._requested.wait()
            self._requested.clear()
            self._cancel_details()
            if self._to_open is not None:
                opening, self._to_open = self._to_open, None
                if await self._send_answer(partial(self.front.open, opening)):
                    self._opening = opening
            if self._newest is not None and self._to_open is None:
                message, self._newest = self._newest, None
                if await self._send_answer(partial(self.front.ask, "seen", self._opening, message)):
                    self._details = asyncio.create_task(
                        self._guarded(partial(self._send_details, message))
                    )
                    for request in REFINEMENTS:
                        if self._requested.is_set():  # the user goes on
                            break
                        await self._send_answer(
                            partial(self.front.ask, request, self._opening, message)
                        )

    def _cancel_details(self) -> None:
        """Cancel the computation of slow results."""
        if self._details is not None:
            self._details.cancel()

    async def _send_details(self, message: Message) -> None:
        """Send requirements, complete scenes and details, one after another, until the user
        continues.
        """
        for request, pause in PAUSES.items():
            await asyncio.sleep(pause)
            if not await self._send_answer(
                partial(self.background.ask, request, self._opening, message)
            ):
                return

    async def _send_answer(self, request: Task) -> bool:
        """Send the answer of a request, or its error message; return whether it succeeded."""
        try:
            answer = await request()
        except GivenUpError:
            return False
        except Exception as error:
            await self._send({"error": describe_error(error)})
            return False
        await self._send_text(answer.text)
        return bool(answer.done)

    async def _send(self, message: Message) -> None:
        await self._send_text(json.dumps(message))

    async def _send_text(self, text: str) -> None:
        try:
            await self.socket.send_text(text)
        except (RuntimeError, WebSocketDisconnect):
            return
