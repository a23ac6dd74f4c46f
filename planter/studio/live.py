"""A page's live line: of what it asks only the newest is computed; what takes longer follows when its hand rests."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Coroutine, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from starlette.websockets import WebSocket, WebSocketDisconnect

from planter import legible
from planter.errors import InputError, PlanterError
from planter.files.text import LIMIT_BYTES, parse_json
from planter.studio.exports import Work, export
from planter.studio.process import Process
from planter.studio.remote import GivenUpError, RemoteSession, Request
from planter.studio.search import search
from planter.studio.session import Message, sources

RESTS: Mapping[Request, float] = {"checked": 0.1, "finished": 0.0, "details": 0.4, "ends": 0.1}
"""What is computed when a hand rests, and for how much longer it must [s]."""
LONGEST_MESSAGE = 2 * LIMIT_BYTES
"""Characters of a message: those of a file, with signs that JSON writes by two."""
ANSWERED: Mapping[str, Request] = {"file": "file", "wish": "wished"}
"""What is answered at once, by what a page asks."""


class Live:
    """One page's line. Two processes have its machine: one follows the hand, one computes when it rests."""

    def __init__(self, socket: WebSocket, folder: Path, explicit: Path | None = None) -> None:
        self.socket, self.folder = socket, folder.resolve()
        self._scratch = TemporaryDirectory(prefix="planter-", ignore_cleanup_errors=True)
        self.front, self.beside = (
            RemoteSession(self.folder, Path(self._scratch.name, name), explicit) for name in ("front", "beside")
        )
        self.search, self.export = Process("search", self._send), Process("export", self._send)
        self._to_open: Message | None = None
        self._newest: Message | None = None
        self._opening: Message = {}
        self._asked = asyncio.Event()
        self._resting: asyncio.Task[None] | None = None
        self._tasks: set[asyncio.Task[None]] = set()

    async def run(self) -> None:
        """Until the page leaves."""
        await self.socket.accept()
        await self._send({"sources": sources(self.folder)})
        self._begin(self.front.begin())
        self._begin(self._follow())
        try:
            while True:
                try:
                    await self._take(await self._heard())
                except InputError as error:
                    await self._send(error_message(error))
        except WebSocketDisconnect:
            pass
        finally:
            self._rest()
            for task in self._tasks:
                task.cancel()
            self.search.cancel()
            self.export.cancel()
            await self.front.close()
            await self.beside.close()
            self._scratch.cleanup()

    async def _heard(self) -> Message:
        """The next message. Raises InputError for what is no JSON object, or too large."""
        try:
            return parse_json(await self.socket.receive_text(), "the message", LONGEST_MESSAGE)
        except KeyError:
            raise InputError("the message must be text") from None

    async def _take(self, message: Message) -> None:
        if "values" in message and "ask" not in message:
            self._newest = message
            self._asked.set()
        elif message.get("ask") == "cancel":
            (self.export if message.get("work") == "export" else self.search).cancel()
        elif message.get("ask") == "open":
            self._to_open, self._newest = message, None
            self._asked.set()
            self._rest()
            self.search.cancel()
            self.front.interrupt()
            self.beside.interrupt()
        else:
            await self._answer(message)

    async def _answer(self, message: Message) -> None:
        ask = message.get("ask")
        if ask == "optimise":
            self.search.begin(self._search(message))
        elif ask == "export":
            self.export.begin(self._export(message))
        elif isinstance(ask, str) and ask in ANSWERED:
            self._begin(self._told(self.front.ask(ANSWERED[ask], self._opening, message)))
        else:
            await self._send({"error": f"ask = {legible.value(ask)} is not allowed"})

    def _begin(self, work: Coroutine[Any, Any, Any]) -> None:
        """Do something beside what the page says next; every exception becomes a message."""
        task = asyncio.create_task(self._guarded(work))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _guarded(self, work: Coroutine[Any, Any, Any]) -> None:
        try:
            await work
        except Exception as error:
            await self._send(error_message(error))

    async def _search(self, message: Message) -> None:
        machine = self._opening
        asked = (await self.front.ask("search", machine, message)).table()
        answer = await search(self.search, asked["command"], asked["labels"])
        found = await self.front.ask("sought", machine, {"answer": answer})
        await self.search.send(found.table())

    async def _export(self, message: Message) -> None:
        found = (await self.front.ask("works", self._opening, message)).table()
        works = [Work(one["name"], Path(one["there"]), one["command"]) for one in found["works"]]
        await export(self.export, self.folder, works)

    async def _follow(self) -> None:
        """Compute the newest that was asked for, and what takes longer once nothing newer came for a while."""
        while True:
            await self._asked.wait()
            self._asked.clear()
            self._rest()
            if self._to_open is not None:
                opening, self._to_open = self._to_open, None
                if await self._told(self.front.open(opening)):
                    self._opening = opening
            if self._newest is not None and self._to_open is None:
                message, self._newest = self._newest, None
                if await self._told(self.front.ask("seen", self._opening, message)):
                    self._resting = asyncio.create_task(self._guarded(self._rested(message)))

    def _rest(self) -> None:
        """Compute no more of what was begun when the hand rested."""
        if self._resting is not None:
            self._resting.cancel()

    async def _rested(self, message: Message) -> None:
        """Requirements, all that there is to see, details: one after another, until the hand moves on."""
        for what, rest in RESTS.items():
            await asyncio.sleep(rest)
            if not await self._told(self.beside.ask(what, self._opening, message)):
                return

    async def _told(self, asked: Coroutine[Any, Any, Any]) -> bool:
        """Send an answer, or the sentence of an error; whether there was none."""
        try:
            answer = await asked
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
    """An exception as a message: the sentence of an error of this project, and the kind of any other."""
    if isinstance(error, PlanterError):
        return {"error": error.message}
    return {"error": legible.line(f"this cannot be done ({type(error).__name__}: {error})")}
