"""Ranges of the numbers of a file, as its class defines them."""

from __future__ import annotations

import re
from functools import cache
from typing import Any

from pydantic import BaseModel

from planter.files.fields import LARGEST


def of(model: type[BaseModel], path: str) -> tuple[float | None, float | None]:
    """Return the smallest and largest number at a path such as `mass.sun_kg` or `nozzle.hinge_A_mm[0]`, in its unit.

    None stands for the general limit of all numbers. Raises KeyError if the class does not have the path.
    """
    root = _schema(model)
    node = root
    for part in re.findall(r"[^.\[\]]+", path):
        node = _followed(node, root)
        node = node["prefixItems"][int(part)] if "prefixItems" in node else node["properties"][part]
    low = max(node.get(key, -LARGEST) for key in ("minimum", "exclusiveMinimum"))
    high = min(node.get(key, LARGEST) for key in ("maximum", "exclusiveMaximum"))
    return None if low == -LARGEST else float(low), None if high == LARGEST else float(high)


@cache
def _schema(model: type[BaseModel]) -> dict[str, Any]:
    """Return the JSON schema of a class."""
    return model.model_json_schema()


def _followed(schema: dict[str, Any], root: dict[str, Any]) -> dict[str, Any]:
    """Return the target of a reference; other schemas are returned unchanged."""
    reference: str = schema.get("$ref", "")
    return root["$defs"][reference.rpartition("/")[2]] if reference else schema
