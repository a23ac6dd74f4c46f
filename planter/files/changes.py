"""Numbers set on the command line, which enter a table before it is validated."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, get_args

from pydantic import BaseModel

from planter import safe_text
from planter.errors import InputError
from planter.files import paths, schema
from planter.files.complaints import not_allowed
from planter.files.paths import Location


def applied(
    model: type[BaseModel], table: Mapping[str, Any], source: str, changes: Mapping[str, float]
) -> tuple[dict[str, Any], list[str]]:
    """Return a copy of the table of a file with changed numbers, and their full paths.

    A name is a full path (`mass.sun_kg`, `nozzle.hinge_A_mm[0]`) or a last part that fits one path only; values are in
    the unit that the name ends in. Raises InputError for an unknown or ambiguous name.
    """
    full_table = schema.filled(model, table)
    locations = _numbers(full_table)
    names = paths.Names(locations.keys())
    values: dict[Location, float] = {}
    for name, value in changes.items():
        candidates = names.candidates(name)
        if len(candidates) != 1:
            raise InputError(not_allowed(source, name, value, names.complaint(name), changed=True))
        location = locations[candidates[0]]
        kind = schema.annotation(model, location)
        is_integer = int in (kind, *get_args(kind)) and float(value).is_integer()
        values[location] = int(value) if is_integer else value
    return paths.with_values(full_table, values), [paths.join(location) for location in values]


def _numbers(table: Mapping[str, Any]) -> dict[str, Location]:
    """Return the locations of the numbers of a table by path, including numbers in quotes."""
    rows: Iterable[tuple[Location, Any]] = paths.places({k: v for k, v in table.items() if k != "origin"})
    return {paths.join(location): location for location, value in rows if _is_number(value)}


def _is_number(value: Any) -> bool:
    if isinstance(value, str):
        try:
            float(safe_text.replace_decimal_comma(value) or value)
        except ValueError:
            return False
        return True
    return isinstance(value, int | float)
