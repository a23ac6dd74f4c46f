"""A search for the best design: the command of the command line, its progress, its optimum."""

from __future__ import annotations

import json
from pathlib import Path

from planter.studio.process import Process


async def search(process: Process, machine: Path, model: str) -> None:
    """Search from a machine's file, and send the optimum."""
    await process.send({"searching": machine.name})
    found = json.loads(await process.command("optimise", str(machine), "--model", model, "--json"))
    design = {f"design.{name}": value for name, value in found["design"].items()}
    told = {key: found[key] for key in ("start_objective", "objective") if key in found}
    await process.send({"optimum": design, **told, "certificate": found.get("certificate")})
