"""JSON schemas of the results of commands, built from the types of records."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from pydantic import TypeAdapter
from pydantic.json_schema import GenerateJsonSchema, JsonSchemaValue
from pydantic_core import core_schema

from planter import plugins


class _Keys(GenerateJsonSchema):
    """Generator of schemas in which optional keys are never null, as in `Record`, and keys have no
    titles.
    """

    def field_title_should_be_set(self, schema: object) -> bool:
        return False

    def default_schema(self, schema: core_schema.WithDefaultSchema) -> JsonSchemaValue:
        inner = schema["schema"]
        return self.generate_inner(inner["schema"] if inner["type"] == "nullable" else inner)


def load_result_types() -> dict[str, Any]:
    """Return the record, or union of records, of each command of all packages, by name."""
    return {
        name: kind
        for package in plugins.load_modules("results")
        for name, kind in package.COMMANDS.items()
    }


def build_schema(command: str, kind: Any) -> Mapping[str, Any]:
    """Return the JSON schema (2020-12) of the result of a command."""
    generated = TypeAdapter(kind).json_schema(mode="serialization", schema_generator=_Keys)
    return {
        "$schema": GenerateJsonSchema.schema_dialect,
        **generated,
        "title": f"planter {command} --json",
    }


def format_schema(command: str, kind: Any) -> str:
    """Return the text of the file of a schema."""
    return json.dumps(build_schema(command, kind), indent=1) + "\n"
