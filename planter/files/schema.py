"""What a file's class says of its tables: the kind of the value at a place, the values that a file may leave out."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from planter.files.paths import Location


def annotation(model: type[BaseModel], location: Location) -> Any:
    """Return the type of the value at a location, for items that of their list; None for an unknown location."""
    kind: Any = model
    for part in location:
        if isinstance(part, str) and get_origin(kind) is dict:
            kind = get_args(kind)[1]
        elif isinstance(part, str):
            table = section(kind)
            field = fields(table).get(part) if table else None
            kind = field.annotation if field else None
    return kind


def section(kind: Any) -> type[BaseModel] | None:
    """Return the class of a table in a type such as `Section`, `Section | None` or `list[Section]`."""
    if isinstance(kind, type) and issubclass(kind, BaseModel):
        return kind
    inner = () if get_origin(kind) is dict else get_args(kind)
    return next(filter(None, map(section, inner)), None)


def fields(model: type[BaseModel]) -> dict[str, FieldInfo]:
    """Return the fields of a table by their keys in a file."""
    return {field.alias or name: field for name, field in model.model_fields.items()}


def filled(model: type[BaseModel], table: Mapping[str, Any]) -> dict[str, Any]:
    """Return a table with the default values of missing keys."""
    values = dict(table)
    for key, field in fields(model).items():
        inner = section(field.annotation)
        if key not in table:
            value = None if field.is_required() else field.get_default(call_default_factory=True)
            if isinstance(value, BaseModel):
                value = value.model_dump(mode="json", by_alias=True, exclude_none=True)
            if value is not None:
                values[key] = value
        elif inner is not None and isinstance(table[key], dict):
            values[key] = filled(inner, table[key])
    return values
