"""The committed schemas of results."""

from __future__ import annotations

import json
from typing import Any

from planter.records import schema


def committed(command: str) -> dict[str, Any]:
    """The JSON schema of a command's result, as it is shipped."""
    found: dict[str, Any] = json.loads((schema.FOLDER / schema.file_name(command)).read_text(encoding="utf-8"))
    return found
