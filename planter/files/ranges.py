"""What range the number at a path of a file may have, as its class says."""

from __future__ import annotations

import re
from functools import cache
from typing import Any

from pydantic import BaseModel

from planter.files.fields import LARGEST


def of(model: type[BaseModel], path: str) -> tuple[float | None, float | None]:
    """The least and the largest number at a path such as `mass.sun_kg` or `nozzle.hinge_A_mm[0]`, in its unit.

    None where only the size of all numbers is limited. Raises KeyError for a path that the class does not know.
    """
    whole = _schema(model)
    found = whole
    for part in re.findall(r"[^.\[\]]+", path):
        found = _followed(found, whole)
        found = found["prefixItems"][int(part)] if "prefixItems" in found else found["properties"][part]
    low = max(found.get(key, -LARGEST) for key in ("minimum", "exclusiveMinimum"))
    high = min(found.get(key, LARGEST) for key in ("maximum", "exclusiveMaximum"))
    return None if low == -LARGEST else float(low), None if high == LARGEST else float(high)


@cache
def _schema(model: type[BaseModel]) -> dict[str, Any]:
    """What the class says of its numbers, put together once."""
    return model.model_json_schema()


def _followed(schema: dict[str, Any], whole: dict[str, Any]) -> dict[str, Any]:
    """What a reference points to; what is none stays."""
    reference: str = schema.get("$ref", "")
    return whole["$defs"][reference.rpartition("/")[2]] if reference else schema
