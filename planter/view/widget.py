"""The drawing as a widget of a notebook."""

from __future__ import annotations

from functools import cache
from typing import Any

from planter.errors import InputError
from planter.view.block import text
from planter.view.channels import packed
from planter.view.picture import picture
from planter.view.scene import Scene
from planter.view.subject import Values, drawn, first_scene, opened


def widget(scene: Scene) -> Any:
    """A scene as a widget; its traits `picture` and `record` may be set anew together with `hold_sync`.

    Raises InputError where anywidget is missing (`planter[notebook]` brings it).
    """
    return _kind()(picture=picture(scene), record=dict(packed(scene)))


def show(source: str, changes: Values | None = None, model: str | None = None) -> Any:
    """A machine of any kind as it moves: a file or a built-in name, some of its numbers changed, in one of its models.

    Raises InputError for what is no machine or model, and where anywidget is missing.
    """
    return widget(first_scene(opened(source, changes), model, f"model = {model}")[0])


def show_object(thing: object) -> Any:
    """An object of some room as it moves. Raises InputError as `drawn` does, and where anywidget is missing."""
    return widget(drawn(thing))


@cache
def _kind() -> Any:
    try:
        import anywidget
        import traitlets
    except ImportError:
        raise InputError("show needs anywidget, which is not installed: pip install 'planter[notebook]'") from None

    class Drawing(anywidget.AnyWidget):
        """A mechanism in motion."""

        _esm = text("view.js")
        _css = text("view.css")
        picture = traitlets.Unicode().tag(sync=True)
        record = traitlets.Dict().tag(sync=True)

    return Drawing
