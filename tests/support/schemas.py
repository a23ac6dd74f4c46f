"""JSON schemas of the results of commands."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

from planter.files import schema


@cache
def load_schema(command: str) -> Mapping[str, Any]:
    """Return the JSON schema of a command's result, as `planter schema` prints it."""
    return schema.build_schema(command, schema.load_result_types()[command])
