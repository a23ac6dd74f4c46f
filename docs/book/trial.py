"""The page with machines to try: built where the compiler of the extra `compiler` is, told where it is not."""

from __future__ import annotations

from pathlib import Path

from book.derived import derive_example
from planter.errors import InputError

FOLDER = Path(__file__).parents[1] / "made" / "pages"
"""Where pages lie that are part of the documentation as they are."""
MACHINES = {"wang2017": "planting device", "slider_crank": "slider-crank"}
"""Machines to try: a built-in one and one of the reader's own kind, and what they are."""
TEXT = """\
# Try a machine before you install anything

Pages that compute by themselves: move a slider, and mechanism, curves and results follow. *Save file* gives a
machine file that every command takes. `planter studio wang2017 --static page.html` writes such a page of any
planting device, with its own families, masses and bounds, or of a mechanism of your own; `planter studio` has
requirements, teeth and optima too.
"""
DEVICE = """
## The planting device

Wang et al. (2017), in both models; *Improve* runs a local optimisation from the current design.
"""
OWN = """
## A mechanism of your own

The slider-crank of [the guide](../own.md), as `planter derive` makes it of its statement.
"""
THERE = """
<p><a href="../{machine}.html">The page alone</a>; it is one file.</p>
<iframe src="../{machine}.html" title="{words} to try" loading="lazy"
 style="width: 100%; height: 70rem; border: 1px solid #8888"></iframe>
"""
MISSING = "\n*This build of the documentation is without it: planter[compiler] was not there.*\n"


def page() -> str:
    """The page's text; the machines' own pages are written beside it."""
    parts = (text + embed(name) for text, name in zip((DEVICE, OWN), MACHINES, strict=True))
    return "".join([TEXT, *parts])


def embed(name: str) -> str:
    """Where a machine's own page is shown."""
    from planter.studio.static_page import write_page

    FOLDER.mkdir(parents=True, exist_ok=True)
    try:
        write_page(derive_example(name), FOLDER / f"{name}.html")
    except InputError:
        return MISSING
    return THERE.format(machine=name, words=MACHINES[name])
