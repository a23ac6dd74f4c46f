"""From the drawing of a mechanism to code: derive equations symbolically, and write them for every
target.

The toolkit's names are those of `derive.toolkit`; it is loaded when the first of them is used, so
that `import derive` and the help of `python -m derive` need no SymPy.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .toolkit import *  # noqa: F403


def __getattr__(name: str) -> Any:
    if name != "__all__" and name.startswith("_"):
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(".toolkit", __name__), name)


def __dir__() -> list[str]:
    names: list[str] = __getattr__("__all__")
    return names
