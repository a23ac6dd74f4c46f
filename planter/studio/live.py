"""A page's live line: of what it asks only the newest is computed; what takes longer follows when its hand rests."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from starlette.websockets import WebSocket, WebSocketDisconnect

from planter.errors import InputError, PlanterError
from planter.files.text import LIMIT_BYTES, parse_json
from planter.studio.aside import Aside, Later
from planter.studio.exports import export
from planter.studio.process import Process
from planter.studio.search import search
from planter.studio.session import Message, Session, told

RESTS: Mapping[Later, float] = {"checked": 0.1, "finished": 0.0, "details": 0.4}
"""What is computed when a hand rests, and for how much longer it must [s]."""
LONGEST_MESSAGE = 2 * LIMIT_BYTES
"""Characters of a message: those of a file, with signs that JSON writes by two."""


class Live:
    """One page's line."""

    def __init__(self, socket: WebSocket, folder: Path) -> None:
        self.socket, self.session = socket, Session(folder)
        self.search, self.export = Process("search", self._send), Process("export", self._send)
        self.aside = Aside(folder)
        self._newest: Message = {}
        self._opening: Message = {}
        self._asked = asyncio.Event()
        self._resting: asyncio.Task[None] | None = None

    async def run(self) -> None:
        """Until the page leaves."""
        await self.socket.accept()
        await self._send({"sources": self.session.sources()})
        follower = asyncio.create_task(self._follow())
        try:
            while True:
                await self._take(await self._heard())
        except WebSocketDisconnect:
            pass
        finally:
            follower.cancel()
            self._rest()
            self.search.cancel()
            self.export.cancel()
            self.aside.close()
            self.session.close()

    async def _heard(self) -> Any:
        """The next message; None for what is no JSON object, or too large."""
        try:
            return parse_json(await self.socket.receive_text(), "the message", LONGEST_MESSAGE)
        except (InputError, KeyError):
            return None

    async def _take(self, message: Any) -> None:
        if not isinstance(message, dict):
            await self._send({"error": "a message must be a JSON object"})
        elif "values" in message and "ask" not in message:
            self._newest = message
            self._asked.set()
        elif message.get("ask") == "cancel":
            (self.export if message.get("work") == "export" else self.search).cancel()
        else:
            await self._answer(message)

    async def _answer(self, message: Message) -> None:
        ask = message.get("ask")
        if ask == "open":
            if await self._told(lambda: {"opened": self.session.open(message)}):
                self._opening = message
        elif ask == "file":
            await self._told(lambda: {"file": self.session.file(message)})
        elif ask == "wish":
            await self._told(lambda: {"wished": self.session.wished(message)})
        elif ask == "optimise":
            self.search.begin(self._search(message))
        elif ask == "export":
            self.export.begin(self._export(message))
        else:
            await self._send({"error": f"ask = {ask} is not allowed"})

    async def _search(self, message: Message) -> None:
        await search(self.search, *await asyncio.to_thread(self.session.search, message))

    async def _export(self, message: Message) -> None:
        works = await asyncio.to_thread(self.session.works, message)
        await export(self.export, self.session.folder, works)

    async def _follow(self) -> None:
        """Compute the newest that was asked for, and what takes longer once nothing newer came for a while."""
        while True:
            await self._asked.wait()
            self._asked.clear()
            message = self._newest
            self._rest()
            if await self._told(partial(self._seen, message)):
                self._resting = asyncio.create_task(self._rested(message))

    def _rest(self) -> None:
        """Compute no more of what was begun when the hand rested."""
        if self._resting is not None:
            self._resting.cancel()

    async def _rested(self, message: Message) -> None:
        """Requirements, all that there is to see, details: one after another, until the hand moves on."""
        try:
            for what, rest in RESTS.items():
                await asyncio.sleep(rest)
                if found := await self.aside.told(what, self._opening, message):
                    await self._send({"id": message.get("id"), **found})
        except PlanterError as error:
            await self._send({"id": message.get("id"), **told(error)})

    def _seen(self, message: Message) -> dict[str, Any]:
        return {"id": message.get("id"), **self.session.seen(message)}

    async def _told(self, compute: Callable[[], dict[str, Any]]) -> bool:
        """Send what is computed, in a thread of its own, or the sentence of its error; whether there was none."""
        try:
            await self._send(await asyncio.to_thread(compute))
        except PlanterError as error:
            await self._send({"id": self._newest.get("id"), **told(error)})
            return False
        return True

    async def _send(self, message: Message) -> None:
        try:
            await self.socket.send_json(message)
        except (RuntimeError, WebSocketDisconnect):
            return
