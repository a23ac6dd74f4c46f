"""Planting-machine mechanisms, from the printed equation to the optimum.

The numeric part: it reads machine files, evaluates the generated equations of motion and optimises designs. SI units
and radians throughout. Nothing heavy is imported before a name is used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from planter.version import __version__

if TYPE_CHECKING:
    from planter.kernels import Kernel
    from planter.planting.batches import evaluate_many
    from planter.planting.file import load as load_machine
    from planter.planting.model import Device
    from planter.planting.turns import Turns

__all__ = ["Device", "Kernel", "Turns", "__version__", "evaluate_many", "load_machine"]

_HOMES = {
    "Device": ("planter.planting.model", "Device"),
    "Kernel": ("planter.kernels", "Kernel"),
    "Turns": ("planter.planting.turns", "Turns"),
    "evaluate_many": ("planter.planting.batches", "evaluate_many"),
    "load_machine": ("planter.planting.file", "load"),
}


def __getattr__(name: str) -> object:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module, own = _HOMES[name]
    return getattr(import_module(module), own)


def __dir__() -> list[str]:
    return __all__
