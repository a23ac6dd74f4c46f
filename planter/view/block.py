"""The drawing as a part of a report: a static SVG picture, and the data that a script animates it with."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from importlib import resources

from planter.report.html import escape
from planter.view.channels import packed
from planter.view.picture import picture
from planter.view.scene import Scene


@dataclass(frozen=True)
class Motion:
    """An animated scene as a block of a page."""

    scene: Scene
    caption: str = ""

    @property
    def script(self) -> str:
        """The ES module that moves drawings."""
        return text("view.js")

    @property
    def style(self) -> str:
        """The style of drawings."""
        return text("view.css")

    def html(self, name: str) -> str:
        """Return the block as HTML; `name` is unique on the page."""
        caption = f"<figcaption>{escape(self.caption)}</figcaption>" if self.caption else ""
        return "\n".join(
            (
                f'<figure id="{name}">',
                '<div class="planter-view" data-view="still" tabindex="0">',
                picture(self.scene),
                f'<script type="application/json">{_safe(json.dumps(packed(self.scene)))}</script>',
                "</div>",
                caption,
                "</figure>",
            )
        )


@cache
def text(name: str) -> str:
    """Return the text of a file of this package."""
    return resources.files(__package__).joinpath(name).read_text(encoding="utf-8")


def _safe(text: str) -> str:
    """Return JSON for an HTML script element, which nothing in it can end."""
    return text.replace("<", "\\u003c").replace("&", "\\u0026")
