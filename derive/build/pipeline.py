"""Everything that `generated/` holds, as texts by path: code (`derive`), verdicts (`audit`)."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from .. import papers
from ..audit import verdicts as audit
from ..discovery import modules
from .generation import code


def verdicts(committed: Path | None = None) -> dict[str, str]:
    """Path inside `generated/` -> content: what the audit found of every equation and of the laws."""
    return audit.verdicts(modules(papers), committed)


PARTS: dict[str, Callable[[Path | None], dict[str, str]]] = {"code": lambda _: code(), "audit": verdicts}
VERDICTS = frozenset(audit.FILES)
