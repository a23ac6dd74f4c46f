"""The drawing as a part of a report: its picture, which stands there without scripts, and what moves in it."""

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
    """A scene as a block of a page."""

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
    """A file of this package."""
    return resources.files(__package__).joinpath(name).read_text(encoding="utf-8")


def _safe(text: str) -> str:
    """JSON within a page: nothing in it ends the element that it stands in."""
    return text.replace("<", "\\u003c").replace("&", "\\u0026")
