"""The JSON schema of every command's result, made of its record's types."""

from __future__ import annotations

import json
from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter
from pydantic.json_schema import GenerateJsonSchema, JsonSchemaValue
from pydantic_core import core_schema

from planter import rooms

FOLDER = Path(str(resources.files("planter"))) / "schemas"
"""Where the schemas stand, a file for each command: that of `planter clutch geometry` is `clutch-geometry.json`."""


class _Keys(GenerateJsonSchema):
    """A key that may be missing is never null, as `Record` says; keys need no titles beside their names."""

    def field_title_should_be_set(self, schema: object) -> bool:
        return False

    def default_schema(self, schema: core_schema.WithDefaultSchema) -> JsonSchemaValue:
        inner = schema["schema"]
        return self.generate_inner(inner["schema"] if inner["type"] == "nullable" else inner)


def results() -> dict[str, Any]:
    """What the commands of all rooms return, record or union of records, by the command's name."""
    return {name: kind for room in rooms.brought("results") for name, kind in room.COMMANDS.items()}


def schema(command: str, kind: Any) -> Mapping[str, Any]:
    """The JSON schema (2020-12) of a command's result."""
    found = TypeAdapter(kind).json_schema(mode="serialization", schema_generator=_Keys)
    return {"$schema": GenerateJsonSchema.schema_dialect, **found, "title": f"planter {command} --json"}


def texts() -> dict[str, str]:
    """The schemas of this package's own commands as the files of their folder."""
    own = {room.__name__: room.COMMANDS for room in rooms.brought("results") if room.__name__.startswith("planter.")}
    return {file_name(command): text(command, kind) for commands in own.values() for command, kind in commands.items()}


def text(command: str, kind: Any) -> str:
    """A schema as the text of its file."""
    return json.dumps(schema(command, kind), indent=1) + "\n"


def file_name(command: str) -> str:
    """The name of the file of a command's schema.

    >>> file_name("clutch geometry")
    'clutch-geometry.json'
    """
    return f"{command.replace(' ', '-')}.json"
