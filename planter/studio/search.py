"""A search for a better design: the command of the command line, its progress, what it found."""

from __future__ import annotations

import json
from collections.abc import Sequence

from planter.studio.process import Process
from planter.view.subject import Searching


async def search(process: Process, machine: Searching, command: Sequence[str]) -> None:
    """Search with a command of a machine, and send what it found."""
    await process.send({"searching": command[0]})
    found = machine.sought(json.loads(await process.command(*command)))
    await process.send({"optimum": dict(found.values), "sentence": found.sentence})
