"""The families of pitch curves that were generated, each also in terms of its size and swing (`NAME-relative`)."""

from __future__ import annotations

from functools import cache
from types import ModuleType
from typing import Any

from planter import legible
from planter.errors import InputError
from planter.files import paths
from planter.gearing import relative
from planter.kernels import Array, Kernel, generated

_PREFIX = "curve_"


def names() -> tuple[str, ...]:
    """Names of the families."""
    return tuple(name.removeprefix(_PREFIX) for name in generated.names(_PREFIX))


@cache
def module(name: str) -> ModuleType:
    """The functions of a family, or of its description by size and swing."""
    family = relative.family_of(name)
    if family is None:
        return generated.module(_PREFIX + name)
    return relative.module(name, module(family), sidecar(family))


@cache
def sidecar(name: str) -> dict[str, Any]:
    """What a family says of its functions."""
    family = relative.family_of(name)
    return generated.sidecar(_PREFIX + name) if family is None else relative.sidecar(sidecar(family))


def checked(name: str, where: str) -> str:
    """The name, if there is such a family; `where` says in which file and key it stands.

    Raises InputError where there is none.
    """
    if (relative.family_of(name) or name) not in names():
        similar = paths.close(name, names())
        hint = f"did you mean {similar[0]}? " if similar else ""
        raise InputError(
            f"{where} = {legible.value(name)} is not allowed: {hint}it must be one of {', '.join(names())}"
        )
    return name


def own_parameters(family: str, described: Array) -> Array:
    """Parameters of the family itself, in SI, from those of its description."""
    found = Kernel(module(f"{family}{relative.SUFFIX}").own_parameters)
    return found(described=described)["parameters"][:, 0]
