"""What this documentation adds to Sphinx: pages made of the project's own records, and formulas as MathML.

The pages are written to docs/made/ when a build begins; nothing in them is typed by hand.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path

from sphinx.application import Sphinx

from book import (
    commands,
    docstrings,
    drawings,
    errata,
    figures,
    findings,
    formats,
    formulas,
    keys,
    models,
    names,
    reference,
    thumbnails,
    trial,
    works,
)

MADE = Path(__file__).parents[1] / "made"
PAGES = {
    "commands": commands.page,
    "drawings": drawings.page,
    "errata": errata.page,
    "findings": findings.page,
    "formats": formats.page,
    "keys": keys.page,
    "models": models.page,
    "names": names.page,
    "schemas": commands.schemas,
    "topics": commands.topics,
    "trial": trial.page,
    "works": works.page,
    **{task: partial(reference.page, task) for task in reference.PAGES},
}


def write(app: Sphinx) -> None:
    """Writes every page that is made."""
    MADE.mkdir(exist_ok=True)
    for name, page in PAGES.items():
        (MADE / f"{name}.md").write_text(page(), encoding="utf-8")
    drawings.draw(MADE)
    figures.draw(MADE)
    thumbnails.draw_thumbnails(MADE)
    app.config.html_extra_path = [str(trial.FOLDER)]


def setup(app: Sphinx) -> dict[str, bool]:
    """Sphinx calls this."""
    app.connect("builder-inited", write)
    app.connect("autodoc-process-docstring", docstrings.as_restructured_text)
    app.add_html_math_renderer("mathml", (formulas.inline, None), (formulas.block, None))
    app.config.html_math_renderer = "mathml"
    return {"parallel_read_safe": True, "parallel_write_safe": True}
