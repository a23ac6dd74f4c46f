"""Finds and loads what `make derive` wrote: modules and their sidecars."""

from __future__ import annotations

import importlib
import json
from functools import cache
from importlib.resources import files
from types import ModuleType
from typing import Any

from planter.errors import InputError


@cache
def _package() -> str:
    """In a wheel the generated code is part of this package; in a checkout it stands beside it."""
    try:
        importlib.import_module("planter.generated")
    except ModuleNotFoundError:
        return "generated"
    return "planter.generated"


@cache
def module(name: str) -> ModuleType:
    """A generated module; that of a family's description for `curve_...-relative`."""
    from planter import described

    family = described.of(name)
    if family is not None:
        return described.module(name, module(family), sidecar(family))
    return importlib.import_module(f"{_package()}.{name}")


@cache
def sidecar(name: str) -> dict[str, Any]:
    """What is written beside a generated module."""
    from planter import described

    family = described.of(name)
    if family is not None:
        return described.sidecar(sidecar(family))
    text = files(_package()).joinpath(f"{name}.json").read_text(encoding="utf-8")
    content: dict[str, Any] = json.loads(text)
    return content


@cache
def families() -> tuple[str, ...]:
    """Names of the pitch-curve families that were generated."""
    found = (p.name for p in files(_package()).iterdir())
    return tuple(
        sorted(
            n.removeprefix("curve_").removesuffix(".json")
            for n in found
            if n.startswith("curve_") and n.endswith(".json")
        )
    )


def family(name: str, where: str) -> str:
    """The name, if there is such a family; `where` says in which file and key it stands."""
    from planter import described

    if (described.of(name) or name) not in families():
        raise InputError(f"{where} = {name!r} is not allowed: it must be one of {', '.join(families())}")
    return name
