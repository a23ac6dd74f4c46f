"""The process in which a page's machine is opened and computed: a request in, an answer out.

Its memory is limited, and the server may kill it, so that a poisonous file costs a message and no more.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

from planter import legible, rooms, workers
from planter.errors import PlanterError
from planter.studio.session import Message, Session

MEMORY_BYTES = 2 * 2**30
"""Address space of a process, with what its libraries take; none of the machines needs half of it."""
REQUESTS = ("open", "seen", "finished", "checked", "details", "ends", "file", "wished", "search", "sought", "works")
"""Methods of a session that a request may name."""
ECHOED = ("id", "opening")
"""Keys of a message by which the page knows what an answer belongs to."""
DONE, FAILED = "+", "-"
"""First letter of an answer."""


def main() -> None:
    """Answer requests; the first message says which folders the session has."""
    list(rooms.brought("show"))
    import_module("planter.kernels.formulas")  # what takes longest is loaded before anybody waits for it
    workers.serve(_open_session, MEMORY_BYTES)


def _open_session(first: bytes) -> Callable[[bytes], bytes]:
    places = json.loads(first)
    session = Session(*(place and Path(place) for place in map(places.get, ("folder", "scratch", "explicit"))))

    def answer(message: bytes) -> bytes:
        request = json.loads(message)
        return answer_request(session, request["do"], request["message"]).encode("ascii")

    return answer


def answer_request(session: Session, what: str, message: Message) -> str:
    """Return what a session answers, as a text; every exception is an answer, too."""
    echoed = {key: message[key] for key in ECHOED if key in message}
    try:
        if what not in REQUESTS:
            raise ValueError(what)
        found = getattr(session, what)(message)
        return DONE + _to_json({**found, **echoed})
    except PlanterError as error:
        sentence = session.in_page_words(error)
    except MemoryError:
        sentence = f"this needs more memory than the {MEMORY_BYTES / 2**30:g} GB that a page's machine may take"
    except Exception as error:
        sentence = f"this cannot be computed ({type(error).__name__}: {error})"
    return FAILED + _to_json({"error": legible.line(sentence), **echoed})


def _to_json(found: Any) -> str:
    """JSON that a browser reads, in ASCII: numbers that are not finite are null."""
    try:
        return json.dumps(found, allow_nan=False)
    except ValueError:
        return json.dumps(_finite(found), allow_nan=False)


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
