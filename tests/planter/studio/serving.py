"""A studio that runs beside the test, as a user starts it."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from playwright.sync_api import Page, sync_playwright
from websockets.sync.client import ClientConnection, connect

from tests.support.browser import browser


@contextmanager
def studio(folder: Path, *arguments: str) -> Iterator[str]:
    """The address of a studio of a folder, or of that of a file among the arguments."""
    served = any(Path(argument).is_file() for argument in arguments)
    command = [
        sys.executable,
        "-m",
        "planter",
        "studio",
        *arguments,
        "--no-browser",
        *([] if served else ["--folder", str(folder)]),
    ]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        try:
            assert process.stdout is not None
            match = re.search(r"http://\S+", process.stdout.readline())
            assert match, process.stderr.read() if process.stderr else ""
            yield match[0].split("#")[0]
        finally:
            process.terminate()


@contextmanager
def line(address: str, origin: str | None = None) -> Iterator[ClientConnection]:
    """A page's live line."""
    parts = address.split("/", 3)
    with connect(
        address.replace("http", "ws") + "live", origin=origin or f"http://{parts[2]}", max_size=None
    ) as location:
        yield location


@contextmanager
def open_line(address: str, machine: str = "wang2017") -> Iterator[ClientConnection]:
    """A page's live line, on which a machine was opened."""
    with line(address) as talk:
        answer(talk, "opened", ask="open", name=machine)
        yield talk


def answer(talk: ClientConnection, key: str, **message: Any) -> Any:
    """Send a message, and wait for one with a key."""
    talk.send(json.dumps(message))
    return until(talk, key)


def until(talk: ClientConnection, *keys: str) -> Any:
    """The next message that has one of some keys: what stands there."""
    message = message_with(talk, *keys)
    return next(message[key] for key in keys if key in message)


def message_with(talk: ClientConnection, *keys: str) -> dict[str, Any]:
    """The next message that has one of some keys."""
    while True:
        message: dict[str, Any] = json.loads(talk.recv(timeout=120))
        if any(key in message for key in keys):
            return message


@contextmanager
def page_of(
    address: str,
    machine: str = "wang2017-wide",
    prepare: Callable[[Page], None] = lambda page: None,
) -> Iterator[Page]:
    """The studio in a browser that was prepared, when all is there that follows once the hand
    rests.
    """
    path = browser()
    with (
        sync_playwright() as play,
        play.chromium.launch(executable_path=path, args=["--no-sandbox"]) as chromium,
    ):
        page = chromium.new_page()
        prepare(page)
        page.goto(f"{address}#{machine}")
        page.wait_for_selector("body[data-detailed]", timeout=60_000)
        yield page
