"""JSON schemas of the results of commands."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

from planter import menu
from planter.files import schema


@cache
def load_schema(command: str) -> Mapping[str, Any]:
    """Return the JSON schema of a command's result by a name of it, as `planter about schema`."""
    name = menu.current_result(command)
    return schema.build_schema(name, schema.load_result_types()[name])
