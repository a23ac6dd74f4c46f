"""The drawing as a notebook widget."""

from __future__ import annotations

from functools import cache
from typing import Any

from planter.errors import InputError
from planter.view.block import text
from planter.view.channels import packed
from planter.view.picture import picture
from planter.view.scene import Scene
from planter.view.subject import Values, build_scene, first_scene, opened


def widget(scene: Scene) -> Any:
    """Return a scene as a widget; its traits `picture` and `record` can be replaced together with `hold_sync`.

    Raises InputError if anywidget is missing, which `planter[notebook]` installs.
    """
    return _kind()(picture=picture(scene), record=dict(packed(scene)))


def show(source: str, changes: Values | None = None, model: str | None = None) -> Any:
    """Return the motion of a machine, a file or built-in name, with changed numbers and in one of its models.

    Raises InputError if the machine or model does not exist, or if anywidget is missing.
    """
    return widget(first_scene(opened(source, changes), model, f"model = {model}")[0])


def show_object(thing: object) -> Any:
    """Return the motion of an object as a widget.

    Raises InputError if the object cannot be drawn, or if anywidget is missing.
    """
    return widget(build_scene(thing))


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
