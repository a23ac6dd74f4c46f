"""Papers as data, each a module: ``PAPER``, its equations as they stand in print, and ``CASE``, what tries them."""

from __future__ import annotations

import pkgutil
from importlib import import_module
from types import ModuleType


def modules() -> list[ModuleType]:
    """Every paper in this folder."""
    return [import_module(f"{__name__}.{found.name}") for found in pkgutil.iter_modules(__path__)]
