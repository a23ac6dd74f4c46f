"""A page that closes at any moment leaves no coroutine that nobody awaits."""

from __future__ import annotations

import asyncio
import gc
import json
import warnings
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

import pytest
from hypothesis import given, seed
from hypothesis import strategies as st

from planter.studio import live
from planter.studio.live import Live, StudioAnswer
from planter.studio.process import SearchEnding
from tests.attack.test_attack import SEED, share

pytest.importorskip("starlette")
MESSAGES = (
    {"values": {"x": 1}},
    {"ask": "open", "name": "wang2017"},
    {"ask": "file"},
    {"ask": "wish"},
    {"ask": "cancel"},
    {"ask": "optimise"},
    {"ask": "export"},
    {"ask": 3},
    {"values": {}, "ask": "file"},
)


class Socket:
    """A page that sends messages and closes, after some turns of the loop each."""

    def __init__(self, messages: list[tuple[Any, int]]) -> None:
        self.messages, self.sent = list(messages), list[str]()

    async def accept(self) -> None:
        """Accept the page."""

    async def send_text(self, text: str) -> None:
        self.sent.append(text)

    async def receive_text(self) -> str:
        if not self.messages:
            raise live.WebSocketDisconnect
        message, turns = self.messages.pop(0)
        for _ in range(turns):
            await asyncio.sleep(0)
        return json.dumps(message)


async def ask(self: Any, *words: Any) -> StudioAnswer:
    """Answer in place of a process, after a turn of the loop."""
    await asyncio.sleep(0)
    return StudioAnswer(
        '{"works": [], "command": ["help"], "out": "", "labels": {}, "goal": "", "starts": 1}'
    )


async def run_nothing(self: Any, *words: Any) -> SearchEnding:
    """Return the end of a search that is not run."""
    await asyncio.sleep(0)
    return SearchEnding({}, "")


def list_warnings(messages: list[tuple[Any, int]]) -> list[str]:
    """Return what Python warns of while a page sends messages and closes."""
    with pytest.MonkeyPatch.context() as patch, warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        for name in ("open", "ask", "_ask"):
            patch.setattr(live.RemoteSession, name, ask)
        patch.setattr(live.RemoteSession, "start", lambda self: None)
        patch.setattr(live.StudioProcess, "search", run_nothing)
        socket = Socket(messages)
        asyncio.run(Live(Path(mkdtemp())).run(socket))  # type: ignore[arg-type]
        gc.collect()
    assert socket.sent
    return [
        str(warning.message) for warning in caught if issubclass(warning.category, RuntimeWarning)
    ]


@seed(SEED)
@share
@given(messages=st.lists(st.tuples(st.sampled_from(MESSAGES), st.integers(0, 4)), max_size=6))
def test_page_that_closes_leaves_nothing_behind(messages: list[tuple[Any, int]]) -> None:
    assert list_warnings(messages) == []


def test_coroutine_that_nobody_awaits_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    begin = Live._begin

    def begin_early(self: Live, task: Any) -> None:
        coroutine = task()
        begin(self, lambda: coroutine)

    monkeypatch.setattr(Live, "_begin", begin_early)
    assert any("never awaited" in message for message in list_warnings([]))
