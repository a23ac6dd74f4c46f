"""Packages of `planter` and `derive` and their imports; `python -m tests.support.structure` writes
docs/structure.svg.

Every import counts: those within functions, under TYPE_CHECKING, and of a package's `__init__`. The
picture has layers, each package above all that it imports, and the imports that do not follow from
others.
"""

from __future__ import annotations

import ast
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from graphlib import CycleError, TopologicalSorter
from html import escape
from importlib.util import resolve_name
from pathlib import Path

ROOT = Path(__file__).parents[2]
FOUNDATION = "foundation"
"""The modules at the root of a package, which all its packages may import."""
ENTRY_MODULES = ("", ".__main__", ".generation", ".toolkit")
"""Modules that collect a package for its users; nothing inside imports them."""
DISCOVERERS = {"cli"}
"""Packages that import others by their parts, not by name."""
PICTURE = ROOT / "docs" / "structure.svg"
WIDTH, HEIGHT = 118, 40
GAP, RISE, EDGE, TITLE = 14, 46, 24, 34
INK, PAPER, BOX, LINE = "#1b2733", "#ffffff", "#eef2f6", "#7b8da0"
FONT = "font-family='DejaVu Sans, Arial, sans-serif'"


@dataclass(frozen=True)
class ImportGraph:
    """Modules of a root package by name, each with the modules of the root package that it
    imports.
    """

    root: str
    imports: Mapping[str, frozenset[str]]
    package_modules: frozenset[str]

    @classmethod
    def read(cls, folder: Path) -> ImportGraph:
        """Read the modules of a folder, which has the name of the root package."""
        sources = {_name(path, folder): path for path in sorted(folder.rglob("*.py"))}
        imports = {
            name: frozenset(set(_list_imports(path, name, sources)) - {name})
            for name, path in sources.items()
        }
        packages = frozenset(name for name, path in sources.items() if path.name == "__init__.py")
        return cls(folder.name, imports, packages)

    def package(self, module: str) -> str:
        """Return the package, directly below the root, of a module."""
        parts = module.split(".")
        return parts[1] if ".".join(parts[:2]) in self.package_modules - {self.root} else FOUNDATION

    @cached_property
    def packages(self) -> dict[str, frozenset[str]]:
        """Packages, each with the others that it imports, without the entry modules."""
        packages: dict[str, set[str]] = {}
        for module, imported in self.imports.items():
            if module.removeprefix(self.root) not in ENTRY_MODULES:
                package = self.package(module)
                packages.setdefault(package, set()).update(
                    {self.package(other) for other in imported} - {package}
                )
        return {package: frozenset(targets) for package, targets in packages.items()}

    @property
    def edges(self) -> list[tuple[str, str]]:
        """Pairs of a package and one that it imports."""
        return [
            (package, other)
            for package, imported in sorted(self.packages.items())
            for other in sorted(imported)
        ]

    @property
    def levels(self) -> dict[str, int]:
        """The level of each package: one above the highest that it imports. Raises CycleError."""
        levels: dict[str, int] = {}
        for package in TopologicalSorter(self.packages).static_order():
            levels[package] = max(
                (levels[other] + 1 for other in self.packages[package]), default=0
            )
        return levels

    def find_cycle(self) -> list[str]:
        """Return modules that import each other in a cycle, or an empty list."""
        try:
            TopologicalSorter(self.imports).prepare()
        except CycleError as error:
            return list(error.args[1])
        return []

    def list_upward_imports(self, layers: Iterable[Iterable[str]]) -> list[tuple[str, str]]:
        """Return imports from the same layer or a higher one; `layers` lists the lowest first."""
        height = {package: level for level, packages in enumerate(layers) for package in packages}
        return [
            (package, other) for package, other in self.edges if height[other] >= height[package]
        ]

    def list_direct_edges(self) -> list[tuple[str, str]]:
        """Return the edges that do not follow from others, without those to the foundation."""

        def reachable(package: str) -> set[str]:
            imported = self.packages[package]
            return imported.union(*(reachable(other) for other in imported))

        return [
            (package, other)
            for package, other in self.edges
            if other != FOUNDATION
            and not any(other in reachable(via) for via in self.packages[package] - {other})
        ]

    def list_rows(self) -> list[list[str]]:
        """Return the packages of each level, the highest first."""
        levels = self.levels
        levels |= {package: max(levels.values()) + 1 for package in levels.keys() & DISCOVERERS}
        rows = range(max(levels.values()), -1, -1)
        return [sorted(package for package in levels if levels[package] == level) for level in rows]

    def describe(self, package: str) -> str:
        """Return the first line of a package's docstring."""
        path = ROOT / self.root / ("" if package == FOUNDATION else package) / "__init__.py"
        return (ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or "").partition(
            "\n"
        )[0]


@cache
def read_imports(package: str) -> ImportGraph:
    """Return the imports of `planter` or `derive`."""
    return ImportGraph.read(ROOT / package)


def _name(path: Path, folder: Path) -> str:
    parts = path.relative_to(folder.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def _list_imports(path: Path, name: str, modules: Collection[str]) -> Iterator[str]:
    """Yield the modules that a source imports; of `from package import name`, the module of that
    name if it exists.
    """
    package = name if path.name == "__init__.py" else name.rpartition(".")[0]
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in modules)
        elif isinstance(node, ast.ImportFrom):
            base = (
                resolve_name("." * node.level + (node.module or ""), package)
                if node.level
                else str(node.module)
            )
            for alias in node.names:
                inner = f"{base}.{alias.name}"
                if inner in modules or base in modules:
                    yield inner if inner in modules else base


@dataclass(frozen=True)
class Box:
    """The upper left corner of a package in the picture."""

    x: float
    y: float

    @property
    def middle(self) -> float:
        """The x coordinate of the centre."""
        return self.x + WIDTH / 2


def draw_graph(graph: ImportGraph, left: float, width: float) -> tuple[list[str], float]:
    """Return a graph as SVG elements within a width, and its height."""
    rows = graph.list_rows()
    boxes: dict[str, Box] = {}
    for level, row in enumerate(rows):
        start = left + (width - len(row) * WIDTH - (len(row) - 1) * GAP) / 2
        y = EDGE + TITLE + level * (HEIGHT + RISE)
        boxes |= {package: Box(start + i * (WIDTH + GAP), y) for i, package in enumerate(row)}
    lines = [_arrow(boxes[start], boxes[end]) for start, end in graph.list_direct_edges()]
    packages = [_box(box, package, graph.describe(package)) for package, box in boxes.items()]
    title = (
        f"<text x='{left + width / 2}' y='{EDGE + 12}' text-anchor='middle' "
        f"font-size='15'>{graph.root}/</text>"
    )
    return [title, *lines, *packages], EDGE + TITLE + len(rows) * (HEIGHT + RISE) - RISE + EDGE


def _arrow(start: Box, end: Box) -> str:
    y, below = start.y + HEIGHT, end.y
    bend = (below - y) / 2
    path = (
        f"M{start.middle} {y} C{start.middle} {y + bend} {end.middle} {below - bend} "
        f"{end.middle} {below - 5}"
    )
    return (
        f"<path d='{path}' fill='none' stroke='{LINE}' stroke-width='1.1' marker-end='url(#tip)'/>"
    )


def _box(box: Box, name: str, text: str) -> str:
    return (
        f"<g><title>{escape(text)}</title>"
        f"<rect x='{box.x}' y='{box.y}' width='{WIDTH}' height='{HEIGHT}' rx='6' fill='{BOX}' "
        f"stroke='{LINE}'/>"
        f"<text x='{box.middle}' y='{box.y + HEIGHT / 2 + 5}' text-anchor='middle' "
        f"font-size='13.5'>{name}</text></g>"
    )


def draw_picture() -> str:
    """Return the picture of `derive` and `planter` as SVG text."""
    graphs = [read_imports(package) for package in ("derive", "planter")]
    widths = [
        max(len(row) for row in graph.list_rows()) * (WIDTH + GAP) + 2 * EDGE for graph in graphs
    ]
    parts: list[str] = []
    left, height = 0.0, 0.0
    for graph, width in zip(graphs, widths, strict=True):
        elements, graph_height = draw_graph(graph, left, width)
        parts += elements
        left, height = left + width, max(height, graph_height)
    head = (
        f"<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {left} {height}' width='{left}' "
        f"height='{height}' "
        f"{FONT} fill='{INK}'>\n<defs><marker id='tip' viewBox='0 0 8 8' refX='6' refY='4' "
        f"markerWidth='7' "
        f"markerHeight='7' orient='auto'><path d='M0 0 L8 4 L0 8 z' "
        f"fill='{LINE}'/></marker></defs>\n"
        f"<rect width='{left}' height='{height}' fill='{PAPER}'/>\n"
    )
    return head + "\n".join(parts) + "\n</svg>\n"


if __name__ == "__main__":
    PICTURE.write_text(draw_picture(), encoding="utf-8")
