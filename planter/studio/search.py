"""A search for a better design: the command of the command line, its progress, and what it prints."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from planter.studio.process import Process


async def search(process: Process, command: Sequence[str], labels: Mapping[str, str]) -> dict[str, Any]:
    """Search with a command of a machine, and return its result; `labels` as `Process.command` takes them."""
    await process.send({"searching": command[0]})
    found: dict[str, Any] = json.loads(await process.command(command, labels))
    return found
