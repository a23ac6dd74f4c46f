"""A search for the best design in a process of its own: the command of the command line, its progress, its optimum."""

from __future__ import annotations

import asyncio
import json
import sys
from collections.abc import Awaitable, Callable, Iterator
from pathlib import Path
from typing import Any

Send = Callable[[dict[str, Any]], Awaitable[None]]


class Search:
    """At most one search of a page."""

    def __init__(self, send: Send) -> None:
        self._send = send
        self._process: asyncio.subprocess.Process | None = None
        self._task: asyncio.Task[None] | None = None

    async def start(self, machine: Path, model: str) -> None:
        """Search from a machine's file; the one before it is given up."""
        self.cancel()
        command = [sys.executable, "-m", "planter", "optimise", str(machine), "--model", model, "--json"]
        self._process = await asyncio.create_subprocess_exec(
            *command, stdout=asyncio.subprocess.PIPE, stderr=asyncio.subprocess.PIPE
        )
        self._task = asyncio.create_task(self._watch(self._process))

    def cancel(self) -> None:
        """Give the search up."""
        if self._task is not None:
            self._task.cancel()
        if self._process is not None and self._process.returncode is None:
            self._process.terminate()
        self._process = self._task = None

    async def _watch(self, process: asyncio.subprocess.Process) -> None:
        assert process.stdout is not None
        assert process.stderr is not None
        answer = asyncio.create_task(process.stdout.read())
        last = ""
        while part := await process.stderr.read(4096):
            for line in _lines(part.decode("utf-8", "replace")):
                last = line
                await self._send({"progress": line})
        text = await answer
        if await process.wait():
            await self._send({"error": last or "the search was given up"})
            return
        found = json.loads(text)
        design = {f"design.{name}": value for name, value in found["design"].items()}
        told = {key: found[key] for key in ("start_objective", "objective") if key in found}
        await self._send({"optimum": design, **told, "certificate": found.get("certificate")})


def _lines(text: str) -> Iterator[str]:
    """What is left of a text that writes over its own lines."""
    yield from (part for part in text.replace("\r", "\n").split("\n") if part.strip())
