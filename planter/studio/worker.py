"""The process in which a page's machine is opened and computed: a request a line in, an answer a line out.

Its memory is limited, and the server may kill it, so that a poisonous file costs a message and no more.
"""

from __future__ import annotations

import json
import math
import os
import sys
from importlib import import_module
from pathlib import Path
from typing import Any

from planter import legible, rooms, workers
from planter.errors import PlanterError
from planter.studio.session import Message, Session

MEMORY_BYTES = 2 * 2**30
"""Address space of a process, with what its libraries take; none of the machines needs half of it."""
REQUESTS = ("open", "seen", "finished", "checked", "details", "ends", "file", "wished", "search", "sought", "works")
"""Methods of a session that a line may name."""
ECHOED = ("id", "opening")
"""Keys of a message by which the page knows what an answer belongs to."""
DONE, FAILED = "+", "-"
"""First letter of an answer."""


def main() -> None:
    """Answer each line; the first says which folders the session has."""
    _limit_memory()
    answers = _private_output()
    lines = workers.read_lines()
    list(rooms.brought("show"))
    import_module("planter.kernels.formulas")  # what takes longest is loaded before anybody waits for it
    places = json.loads(next(lines))
    session = Session(*(place and Path(place) for place in map(places.get, ("folder", "scratch", "explicit"))))
    for line in lines:
        request = json.loads(line)
        answers.write(answer_request(session, request["do"], request["message"]) + "\n")
        answers.flush()


def answer_request(session: Session, what: str, message: Message) -> str:
    """Return what a session answers, as a line; every exception is an answer, too."""
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


def _limit_memory() -> None:
    """Where the system can: beyond the limit an allocation fails, which costs this process at most."""
    try:
        import resource
    except ImportError:
        return
    hard = resource.getrlimit(resource.RLIMIT_AS)[1]
    limit = MEMORY_BYTES if hard == resource.RLIM_INFINITY else min(MEMORY_BYTES, hard)
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))


def _private_output() -> Any:
    """The standard output for answers alone; what else is printed goes nowhere."""
    answers = os.fdopen(os.dup(1), "w", encoding="ascii")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    sys.stdout = open(os.devnull, "w")  # noqa: SIM115 - open as long as the process
    return answers
