"""The kinds of machines: packages whose module `machines` takes a source, and further modules of
such a package.

A package takes a built-in name, or a file by its tables: those of its `OWN_TABLES`, or by
`machines.takes`. Its other modules serve what it takes: `show` a page, `toothed` gears, `labelled`
drawings, `swept` sweeps and tolerances.
"""

from __future__ import annotations

from importlib import import_module
from types import ModuleType

from planter import plugins
from planter.files import examples


def find_kind(source: str) -> ModuleType | None:
    """Return the module `machines` of the package that takes a source, or None."""
    for name, package in plugins.find_packages().items():  # no other package's machines are loaded
        tables = getattr(import_module(package), "OWN_TABLES", None)
        if tables is not None and examples.belongs_to_package(source, name, tables):
            return import_module(f"{package}.machines")
    for module in plugins.load_modules("machines"):
        if hasattr(module, "takes") and module.takes(source):
            return module
    return None


def load_part(source: str, part: str) -> ModuleType | None:
    """Return a module by its name of the package that takes a source, or of the one whose files a
    file resembles.

    None if there is no such package, or if it has no such module.
    """
    kind = find_kind(source)
    for module in plugins.load_modules(part):
        package = plugins.name_package(module)
        if (
            package == plugins.name_package(kind)
            if kind
            else examples.resembles_package(source, package)
        ):
            return module
    return None
