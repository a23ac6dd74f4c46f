"""The process that opens and computes a page's machine, and answers one request after another.

Its memory is limited, and the server may kill it, so that a malicious file only causes an error message.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

from planter import plugins, safe_text, workers
from planter.errors import PlanterError
from planter.studio.session import Message, Session

MEMORY_BYTES = 2 * 2**30
"""Maximum address space of a process, including its libraries; every machine needs less than half of it."""
REQUESTS = ("open", "seen", "finished", "checked", "details", "ends", "file", "wished", "search", "sought", "works")
"""Methods of a session that a request can name."""
ECHOED = ("id", "opening")
"""Keys of a message that an answer repeats, so that the page can assign it."""
DONE, FAILED = "+", "-"
"""First character of an answer."""


def main() -> None:
    """Answer requests; the first message has the folders of the session."""
    list(plugins.load_modules("show"))
    import_module("planter.kernels.formulas")  # takes longest to load, so that it is loaded before the first request
    workers.serve(_open_session, MEMORY_BYTES)


def _open_session(first: bytes) -> Callable[[bytes], bytes]:
    places = json.loads(first)
    session = Session(*(place and Path(place) for place in map(places.get, ("folder", "scratch", "explicit"))))

    def answer(message: bytes) -> bytes:
        request = json.loads(message)
        return answer_request(session, request["do"], request["message"]).encode("ascii")

    return answer


def answer_request(session: Session, name: str, message: Message) -> str:
    """Return the answer of a session to the request `name` as text; an exception becomes an error answer."""
    echoed = {key: message[key] for key in ECHOED if key in message}
    try:
        if name not in REQUESTS:
            raise ValueError(name)
        answer = getattr(session, name)(message)
        return DONE + _to_json({**answer, **echoed})
    except PlanterError as error:
        sentence = session.in_page_words(error)
    except MemoryError:
        sentence = f"this needs more memory than the {MEMORY_BYTES / 2**30:g} GB that a page's machine may take"
    except Exception as error:
        sentence = f"this cannot be computed ({type(error).__name__}: {error})"
    return FAILED + _to_json({"error": safe_text.sanitise_line(sentence), **echoed})


def _to_json(answer: Any) -> str:
    """Return standard JSON in ASCII; numbers that are not finite become null."""
    try:
        return json.dumps(answer, allow_nan=False)
    except ValueError:
        return json.dumps(_finite(answer), allow_nan=False)


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
