"""A page without a server, and what stands in it for its script."""

from __future__ import annotations

import base64
import gzip
import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from planter.kernels import Array
from tests.support.wasm import Running

Values = Mapping[str, float]


@dataclass(frozen=True)
class Told:
    """A page and what stands in it for its script."""

    file: Path

    @cached_property
    def html(self) -> str:
        return self.file.read_text(encoding="utf-8")

    @cached_property
    def machine(self) -> dict[str, Any]:
        found = re.search(r'<script type="application/json" id="machine">(.*?)</script>', self.html, re.DOTALL)
        assert found
        told: dict[str, Any] = json.loads(found[1])
        return told

    @cached_property
    def module(self) -> bytes:
        return gzip.decompress(base64.b64decode(self.machine["module"]))

    @cached_property
    def running(self) -> Running:
        return Running(self.module)

    def numbers(self, model: str, part: str, values: Values, running: Running | None = None) -> Array:
        """All numbers of a model's program, `seen` or `descent`, as the page's script runs it."""
        told = self.machine["models"][model][part]
        given = {one["at"]: values[one["path"]] * one["factor"] for one in told["inputs"]}
        found = (running or self.running).run(told["name"], self.machine["programs"][told["name"]], given)
        assert found is not None
        return found

    def readings(self, model: str, values: Values, running: Running | None = None) -> dict[str, float]:
        numbers = self.numbers(model, "seen", values, running)
        return {one["name"]: numbers[one["at"]] for one in self.machine["models"][model]["readings"]}

    def designs(self, count: int) -> list[dict[str, float]]:
        """The page's own numbers, then some by lot within their ends."""
        rng, controls = np.random.default_rng(7), self.machine["controls"]
        own = {one["path"]: one["value"] for one in controls}
        return [own, *({one["path"]: float(rng.uniform(one["lower"], one["upper"])) for one in controls}
                       for _ in range(count))]  # fmt: skip


def written(folder: Path, machine: str) -> Told:
    """A page as the command writes it."""
    from planter.studio.static.file import write

    return Told(write(machine, folder / "page.html"))
