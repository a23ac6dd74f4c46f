"""Reference pages by task: stating a mechanism, formulas and papers, running a generated mechanism."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from pkgutil import resolve_name

import derive
from planter.cli.words import load_pages

PAGES = load_pages()
"""Pages by name: their heads, and full names by section."""
SPLIT = (derive.Mechanism, derive.Formulas, derive.Paper)
"""Classes whose members have entries of their own."""
UNLISTED = {
    "anchor",
    "axes",
    "chosen",
    "common",
    "component_axes",
    "data",
    "defined",
    "list_centroids",
    "name_accelerations",
    "name_supports",
    "pin_of",
    "refuse_shared_names",
    "support_forces",
    "told_in",
    "world_components",
}
"""Members of `derive.Mechanism` for derivations, which no statement needs."""


def names(page: str) -> list[str]:
    """Return the full names on a page, in their order."""
    return [name for entries in PAGES[page].sections.values() for name in entries]


def directive(name: str) -> Iterator[str]:
    """Yield the lines by which Sphinx shows a name."""
    item = resolve_name(name)
    parent = resolve_name(name.rpartition(".")[0])
    if isinstance(item, property):
        kind = "autoproperty"
    elif inspect.isclass(item):
        kind = "autoclass"
    elif inspect.isclass(parent):
        kind = "automethod"
    else:
        kind = "autofunction" if callable(item) else "autodata"
    yield f".. {kind}:: {name}"
    if kind == "autodata":
        yield "   :no-value:"
    if (
        kind == "autoclass"
        and item not in (*SPLIT, derive.Quantity)
        and not issubclass(item, Exception)
    ):
        yield "   :members:"
        yield "   :special-members: __call__"
    yield ""


def page(name: str) -> str:
    """Return a page."""
    text = [PAGES[name].head]
    for title, entries in PAGES[name].sections.items():
        text += [f"## {title}", "", "```{eval-rst}"]
        for entry in entries:
            text += directive(entry)
        text += ["```", ""]
    return "\n".join(text)
