"""The house as it is built: which module imports which, which room which, read from the sources.

Every import counts: those within functions, under TYPE_CHECKING, and of a package's own `__init__`.
`tests.support.picture` draws it.
"""

from __future__ import annotations

import ast
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from graphlib import CycleError, TopologicalSorter
from importlib.util import resolve_name
from pathlib import Path

ROOT = Path(__file__).parents[2]
FOUNDATION = "foundation"
"""The room of the modules that stand at the root of a package, which all others may import."""
WAYS_IN = ("", ".__main__", ".generation", ".toolkit")
"""Modules that gather a package for those who come from outside; nothing inside imports them."""


@dataclass(frozen=True)
class House:
    """Modules of a package by name, each with the modules of the package that it imports; its rooms are packages."""

    package: str
    imports: Mapping[str, frozenset[str]]
    packages: frozenset[str]

    @classmethod
    def of(cls, folder: Path) -> House:
        """The house in a folder, which has the package's name."""
        sources = {_name(path, folder): path for path in sorted(folder.rglob("*.py"))}
        found = {name: frozenset(set(_imported(path, name, sources)) - {name}) for name, path in sources.items()}
        packages = frozenset(name for name, path in sources.items() if path.name == "__init__.py")
        return cls(folder.name, found, packages)

    def room(self, module: str) -> str:
        """The room of a module: the package below the root that it stands in."""
        parts = module.split(".")
        return parts[1] if ".".join(parts[:2]) in self.packages - {self.package} else FOUNDATION

    @cached_property
    def rooms(self) -> dict[str, frozenset[str]]:
        """Rooms, each with the other rooms that it imports. The ways into the package belong to none."""
        found: dict[str, set[str]] = {}
        for module, imported in self.imports.items():
            if module.removeprefix(self.package) not in WAYS_IN:
                room = self.room(module)
                found.setdefault(room, set()).update({self.room(other) for other in imported} - {room})
        return {room: frozenset(others) for room, others in found.items()}

    @property
    def arrows(self) -> list[tuple[str, str]]:
        return [(room, other) for room, others in sorted(self.rooms.items()) for other in sorted(others)]

    @property
    def floors(self) -> dict[str, int]:
        """How high a room stands: one floor above the highest that it imports. Raises CycleError."""
        found: dict[str, int] = {}
        for room in TopologicalSorter(self.rooms).static_order():
            found[room] = max((found[other] + 1 for other in self.rooms[room]), default=0)
        return found

    def circle(self) -> list[str]:
        """Modules that import each other in a ring; none where there is no such ring."""
        try:
            TopologicalSorter(self.imports).prepare()
        except CycleError as error:
            return list(error.args[1])
        return []

    def upward(self, layers: Iterable[Iterable[str]]) -> list[tuple[str, str]]:
        """Arrows from a room to one on its own layer or above it; `layers` lists the lowest first."""
        height = {room: level for level, rooms in enumerate(layers) for room in rooms}
        return [(room, other) for room, other in self.arrows if height[other] >= height[room]]


@cache
def standing(package: str) -> House:
    """The house of a package of this project."""
    return House.of(ROOT / package)


def _name(path: Path, folder: Path) -> str:
    parts = path.relative_to(folder.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def _imported(path: Path, name: str, known: Collection[str]) -> Iterator[str]:
    """Modules that a source imports; of `from package import name`, the module of that name if there is one."""
    package = name if path.name == "__init__.py" else name.rpartition(".")[0]
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in known)
        elif isinstance(node, ast.ImportFrom):
            base = resolve_name("." * node.level + (node.module or ""), package) if node.level else str(node.module)
            for alias in node.names:
                inner = f"{base}.{alias.name}"
                if inner in known or base in known:
                    yield inner if inner in known else base
