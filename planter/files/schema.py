"""What a file's class says of its tables: the kind of the value at a place, the values that a file may leave out."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from planter.files.paths import Location


def annotation(model: type[BaseModel], location: Location) -> Any:
    """The type that the class has for the value at a location, items of lists as their list; None where it has none."""
    found: Any = model
    for part in location:
        if isinstance(part, str) and get_origin(found) is dict:
            found = get_args(found)[1]
        elif isinstance(part, str):
            table = section(found)
            field = fields(table).get(part) if table else None
            found = field.annotation if field else None
    return found


def section(kind: Any) -> type[BaseModel] | None:
    """The class of a table in a type such as `Section`, `Section | None` or `list[Section]`."""
    if isinstance(kind, type) and issubclass(kind, BaseModel):
        return kind
    inner = () if get_origin(kind) is dict else get_args(kind)
    return next(filter(None, map(section, inner)), None)


def fields(model: type[BaseModel]) -> dict[str, FieldInfo]:
    """The fields of a table under the keys that a file gives them."""
    return {field.alias or name: field for name, field in model.model_fields.items()}


def filled(model: type[BaseModel], table: Mapping[str, Any]) -> dict[str, Any]:
    """A table with the values that it leaves out, where its class has one for them."""
    found = dict(table)
    for key, field in fields(model).items():
        inner = section(field.annotation)
        if key not in table:
            value = None if field.is_required() else field.get_default(call_default_factory=True)
            if isinstance(value, BaseModel):
                value = value.model_dump(mode="json", by_alias=True, exclude_none=True)
            if value is not None:
                found[key] = value
        elif inner is not None and isinstance(table[key], dict):
            found[key] = filled(inner, table[key])
    return found
