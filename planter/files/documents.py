"""The documentation and its examples: in a wheel a part of `planter`, in a checkout beside it."""

from __future__ import annotations

from functools import cache
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path

from planter import paths
from planter.errors import InputError

UNLISTED = ("index",)
"""Pages that only lead to others."""


@cache
def find_folder() -> Traversable:
    """Return the folder of the documentation."""
    inside = resources.files("planter").joinpath("docs")
    return inside if inside.is_dir() else Path(__file__).parents[2] / "docs"


def list_pages() -> dict[str, str]:
    """Return the titles of the pages by name, sorted."""
    names = (file.name for file in find_folder().iterdir() if file.name.endswith(".md"))
    pages = sorted(name.removesuffix(".md") for name in names)
    return {name: _read_title(read_page(name)) for name in pages if name not in UNLISTED}


def _read_title(text: str) -> str:
    head = next((line for line in text.splitlines() if line.startswith("# ")), "")
    return head.removeprefix("# ")


def read_page(name: str) -> str:
    """Return the text of a page."""
    return find_folder().joinpath(f"{name}.md").read_text(encoding="utf-8")


def list_statements() -> list[str]:
    """Return the names of the example files, sorted."""
    folder = find_folder().joinpath("examples")
    return sorted(file.name for file in folder.iterdir() if file.is_file())


def read_statement(name: str) -> str:
    """Return the text of an example file. Raises InputError for an unknown name."""
    allowed = list_statements()
    if name not in allowed:
        raise InputError.for_value("FILE", name, paths.suggest_names(name, allowed))
    return find_folder().joinpath("examples", name).read_text(encoding="utf-8")
