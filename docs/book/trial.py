"""The page with a machine to try: built where the compiler of the extra `compiler` is, told where it is not."""

from __future__ import annotations

from pathlib import Path

from planter.errors import InputError

FOLDER = Path(__file__).parents[1] / "made" / "pages"
"""Where pages lie that are part of the documentation as they are."""
MACHINE = "wang2017"
TEXT = f"""\
# Try a machine

The planting device of Wang et al. (2017), computed by this page itself: move a slider, and mechanism, support force and
torque follow; both models; *Improve* runs a local optimisation from the current design,
*Save file* gives a machine file that every command takes. `planter studio {MACHINE} --static page.html`
writes such a page of any planting device, with its own families, masses and bounds, or
of a mechanism of your own; `planter studio` has requirements, teeth and optima too.
"""
THERE = f"""
<p><a href="../{MACHINE}.html">The page alone</a>; it is one file.</p>
<iframe src="../{MACHINE}.html" title="planting device to try" loading="lazy"
 style="width: 100%; height: 70rem; border: 1px solid #8888"></iframe>
"""
MISSING = "\n*This build of the documentation is without it: planter[compiler] was not there.*\n"


def page() -> str:
    """The page's text; the machine's own page is written beside it."""
    from planter.studio.static_page import write_page

    FOLDER.mkdir(parents=True, exist_ok=True)
    try:
        write_page(MACHINE, FOLDER / f"{MACHINE}.html")
    except InputError:
        return TEXT + MISSING
    return TEXT + THERE
