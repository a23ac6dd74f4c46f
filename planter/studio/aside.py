"""What takes longest, computed in a process beside the page's own: a hand that moves on never waits for it."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any, Literal

from planter.errors import ComputationError
from planter.studio.session import Message, Session

Later = Literal["checked", "finished", "details"]
"""What a session tells when the hand rests, by the names of its methods."""


class Aside:
    """A process of its own for the machine that a page has open; it starts when it is first asked."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._pool: ProcessPoolExecutor | None = None

    async def told(self, what: Later, opening: Message, message: Message) -> dict[str, Any]:
        """What a session tells of the machine that was opened so. Raises PlanterError, also where the process ended."""
        if self._pool is None:
            self._pool = ProcessPoolExecutor(max_workers=1, mp_context=get_context("spawn"))
        loop = asyncio.get_running_loop()
        try:
            return await loop.run_in_executor(self._pool, _told, self.folder, what, dict(opening), dict(message))
        except BrokenExecutor:
            self._pool = None
            raise ComputationError(
                "the process that computes beside the page ended; the next move starts another"
            ) from None

    def close(self) -> None:
        """End the process."""
        if self._pool is not None:
            self._pool.shutdown(wait=False, cancel_futures=True)


_open: dict[str, Session] = {}
"""In that process: the session of the latest machine, by how it was opened."""


def _told(folder: Path, what: Later, opening: Message, message: Message) -> dict[str, Any]:
    key = repr(opening)
    if key not in _open:
        for session in _open.values():
            session.close()
        _open.clear()
        _open[key] = Session(folder)
        _open[key].open(opening)
    tell: Callable[[Message], dict[str, Any]] = getattr(_open[key], what)
    return tell(message)
