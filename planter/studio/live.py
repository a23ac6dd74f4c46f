"""The WebSocket connection of a page: only its newest request is computed, and slow results follow when it pauses."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Coroutine, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from starlette.websockets import WebSocket, WebSocketDisconnect

from planter import safe_text
from planter.errors import InputError, PlanterError
from planter.files.text import LIMIT_BYTES, parse_json
from planter.studio.process import ExportTask, Process, export_file
from planter.studio.remote import GivenUpError, RemoteSession, Request
from planter.studio.session import Message, list_sources

PAUSES: Mapping[Request, float] = {"checked": 0.1, "finished": 0.0, "details": 0.4, "ends": 0.1}
"""Requests that are computed when the user pauses, with the additional pause before each [s]."""
LONGEST_MESSAGE = 2 * LIMIT_BYTES
"""Maximum characters of a message: those of a file, in which JSON may escape each by two."""
ANSWERED: Mapping[str, Request] = {"file": "file", "wish": "wished"}
"""Requests that are answered immediately, by the `ask` of a message."""


class Live:
    """The connection of a page with two processes: one follows the user, and one computes slow results."""

    def __init__(self, socket: WebSocket, folder: Path, explicit: Path | None = None) -> None:
        self.socket, self.folder = socket, folder.resolve()
        self._scratch = TemporaryDirectory(prefix="planter-", ignore_cleanup_errors=True)
        self.front, self.background = (
            RemoteSession(self.folder, Path(self._scratch.name, name), explicit) for name in ("front", "background")
        )
        self.search, self.export = Process("search", self._send), Process("export", self._send)
        self._to_open: Message | None = None
        self._newest: Message | None = None
        self._opening: Message = {}
        self._requested = asyncio.Event()
        self._details: asyncio.Task[None] | None = None
        self._tasks: set[asyncio.Task[None]] = set()

    async def run(self) -> None:
        """Serve the page until it disconnects."""
        await self.socket.accept()
        await self._send({"sources": list_sources(self.folder)})
        self._begin(self.front.begin())
        self._begin(self._follow())
        try:
            while True:
                try:
                    await self._take(await self._receive())
                except InputError as error:
                    await self._send(error_message(error))
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
        """Return the next message. Raises InputError if it is not a JSON object, or if it is too large."""
        try:
            return parse_json(await self.socket.receive_text(), "the message", LONGEST_MESSAGE)
        except KeyError:
            raise InputError("the message must be text") from None

    async def _take(self, message: Message) -> None:
        if "values" in message and "ask" not in message:
            self._newest = message
            self._requested.set()
        elif message.get("ask") == "cancel":
            (self.export if message.get("work") == "export" else self.search).cancel()
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
            self.search.begin(self._search(message))
        elif ask == "export":
            self.export.begin(self._export(message))
        elif isinstance(ask, str) and ask in ANSWERED:
            self._begin(self._send_answer(self.front.ask(ANSWERED[ask], self._opening, message)))
        else:
            await self._send({"error": f"ask = {safe_text.format_value(ask)}: there is no such request"})

    def _begin(self, task: Coroutine[Any, Any, Any]) -> None:
        """Start a task in the background; an exception becomes an error message."""
        running = asyncio.create_task(self._guarded(task))
        self._tasks.add(running)
        running.add_done_callback(self._tasks.discard)

    async def _guarded(self, task: Coroutine[Any, Any, Any]) -> None:
        try:
            await task
        except Exception as error:
            await self._send(error_message(error))

    async def _search(self, message: Message) -> None:
        machine = self._opening
        task = (await self.front.ask("search", machine, message)).table()
        await self.search.send({"searching": task["command"][0]})
        result = json.loads(await self.search.command(task["command"], task["labels"]))
        optimum = await self.front.ask("sought", machine, {"answer": result})
        await self.search.send(optimum.table())

    async def _export(self, message: Message) -> None:
        answer = (await self.front.ask("works", self._opening, message)).table()
        tasks = [ExportTask(work["name"], Path(work["folder"]), work["command"]) for work in answer["works"]]
        await export_file(self.export, self.folder, tasks)

    async def _follow(self) -> None:
        """Compute the newest request, and slow results after a pause without newer ones."""
        while True:
            await self._requested.wait()
            self._requested.clear()
            self._cancel_details()
            if self._to_open is not None:
                opening, self._to_open = self._to_open, None
                if await self._send_answer(self.front.open(opening)):
                    self._opening = opening
            if self._newest is not None and self._to_open is None:
                message, self._newest = self._newest, None
                if await self._send_answer(self.front.ask("seen", self._opening, message)):
                    self._details = asyncio.create_task(self._guarded(self._send_details(message)))

    def _cancel_details(self) -> None:
        """Cancel the computation of slow results."""
        if self._details is not None:
            self._details.cancel()

    async def _send_details(self, message: Message) -> None:
        """Send requirements, complete scenes and details, one after another, until the user continues."""
        for request, pause in PAUSES.items():
            await asyncio.sleep(pause)
            if not await self._send_answer(self.background.ask(request, self._opening, message)):
                return

    async def _send_answer(self, request: Coroutine[Any, Any, Any]) -> bool:
        """Send the answer of a request, or its error message; return whether it succeeded."""
        try:
            answer = await request
        except GivenUpError:
            return False
        except Exception as error:
            await self._send(error_message(error))
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


def error_message(error: Exception) -> dict[str, str]:
    """Return an exception as a message: the message of an error of planter, or type and text of any other."""
    if isinstance(error, PlanterError):
        return {"error": error.message}
    return {"error": safe_text.sanitise_line(f"this cannot be done ({type(error).__name__}: {error})")}
