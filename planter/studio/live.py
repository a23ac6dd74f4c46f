"""A page's live line: of what it asks only the newest is computed; what takes longer follows when its hand rests."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from starlette.websockets import WebSocket, WebSocketDisconnect

from planter.errors import PlanterError
from planter.studio.aside import Aside
from planter.studio.exports import export
from planter.studio.process import Process
from planter.studio.search import search
from planter.studio.session import Message, Session, told

REST_S = 0.1
"""How long a hand rests before what takes longer is computed."""


class Live:
    """One page's line."""

    def __init__(self, socket: WebSocket, folder: Path) -> None:
        self.socket, self.session = socket, Session(folder)
        self.search, self.export = Process("search", self._send), Process("export", self._send)
        self.aside = Aside(folder)
        self._newest: Message | None = None
        self._opening: Message = {}
        self._detailing: asyncio.Task[None] | None = None
        self._asked = asyncio.Event()

    async def run(self) -> None:
        """Until the page leaves."""
        await self.socket.accept()
        await self._send({"sources": self.session.sources()})
        follower = asyncio.create_task(self._follow())
        try:
            while True:
                await self._take(await self.socket.receive_json())
        except (WebSocketDisconnect, ValueError):
            pass
        finally:
            follower.cancel()
            self.search.cancel()
            self.export.cancel()
            self.aside.close()
            self.session.close()

    async def _take(self, message: Any) -> None:
        if not isinstance(message, dict):
            await self._send({"error": "a message must be an object"})
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
        elif ask == "optimise":
            self.search.begin(self._search(message))
        elif ask == "export":
            self.export.begin(self._export(message))
        else:
            await self._send({"error": f"ask = {ask} is not allowed"})

    async def _search(self, message: Message) -> None:
        file = await asyncio.to_thread(self.session.saved, message)
        await search(self.search, file, str(message.get("model", "exact")))

    async def _export(self, message: Message) -> None:
        works = await asyncio.to_thread(self.session.works, message)
        await export(self.export, self.session.folder, works)

    async def _follow(self) -> None:
        """Compute the newest that was asked for, and what takes longer if nothing newer comes for a while."""
        while True:
            await self._asked.wait()
            self._asked.clear()
            message = self._newest
            assert message is not None
            if not await self._told(partial(self._marked, self.session.seen, message)):
                continue
            try:
                await asyncio.wait_for(self._asked.wait(), REST_S)
            except TimeoutError:
                await self._rested(message)

    async def _rested(self, message: Message) -> None:
        """What takes longer, as long as nothing newer comes: requirements, all that there is to see, details."""
        for compute in (self.session.checked, self.session.finished):
            if not self._asked.is_set():
                await self._told(partial(self._marked, compute, message))
        if self._detailing is not None:
            self._detailing.cancel()
        self._detailing = asyncio.create_task(self._details(message))

    async def _details(self, message: Message) -> None:
        try:
            await self._send({"id": message.get("id"), **await self.aside.details(self._opening, message)})
        except PlanterError as error:
            await self._send({"id": message.get("id"), **told(error)})

    @staticmethod
    def _marked(compute: Callable[[Message], dict[str, Any]], message: Message) -> dict[str, Any]:
        """What is computed of a message, with the message's number."""
        return {"id": message.get("id"), **compute(message)}

    async def _told(self, compute: Callable[[], dict[str, Any]]) -> bool:
        """Send what is computed, in a thread of its own, or the sentence of its error; whether there was none."""
        try:
            await self._send(await asyncio.to_thread(compute))
        except PlanterError as error:
            await self._send({"id": (self._newest or {}).get("id"), **told(error)})
            return False
        return True

    async def _send(self, message: Message) -> None:
        try:
            await self.socket.send_json(message)
        except (RuntimeError, WebSocketDisconnect):
            return
