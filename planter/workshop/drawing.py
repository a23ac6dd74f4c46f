"""Drawings in DXF (R2010, mm): closed outlines as one LWPOLYLINE each, its arcs as bulges, by ezdxf."""

from __future__ import annotations

import io
import threading
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from planter.workshop.arcs import Arcs

if TYPE_CHECKING:
    from ezdxf.document import Drawing

Layer = Literal["TEETH", "PITCH", "BORE", "KEYWAY", "CENTRE", "CONTOUR"]
_COLOURS: dict[Layer, int] = {"TEETH": 7, "CONTOUR": 7, "PITCH": 8, "BORE": 5, "KEYWAY": 6, "CENTRE": 1}
_MM = 1e3
_CENTRE_LINE = ("CENTER", "long and short dashes", [12.0, 8.0, -1.5, 1.0, -1.5])
"""Name, meaning, and pattern [mm]: its length, then dashes, gaps as negative."""
_LOCK = threading.Lock()


@dataclass(frozen=True)
class Line:
    """A curve on a layer."""

    layer: Layer
    arcs: Arcs


def cross(centre: tuple[float, float], reach: float) -> Iterator[Line]:
    """Two centre lines through a point, each as far as `reach` to both sides [m]."""
    for arm in ((reach, 0.0), (0.0, reach)):
        ends = np.array([np.subtract(centre, arm), np.add(centre, arm)])
        yield Line("CENTRE", Arcs(ends, np.zeros(2), closed=False))


def dxf(lines: Iterable[Line]) -> bytes:
    """Curves as a DXF file: the same curves give the same bytes."""
    from ezdxf import units
    from ezdxf.filemanagement import new

    text = io.StringIO()
    with _undated():
        drawing = new("R2010", units=units.MM)
        name, meaning, pattern = _CENTRE_LINE
        drawing.linetypes.add(name, pattern, description=meaning)
        for line in lines:
            _add(drawing, line)
        for kind in sorted(drawing.entitydb.dxf_types_in_use()):  # ezdxf goes through them in the order of a set
            drawing.classes.add_class(kind)
        drawing.write(text)
    return text.getvalue().encode(drawing.output_encoding)


def _add(drawing: Drawing, line: Line) -> None:
    if line.layer not in drawing.layers:
        kind = _CENTRE_LINE[0] if line.layer == "CENTRE" else "CONTINUOUS"
        drawing.layers.add(line.layer, color=_COLOURS[line.layer], linetype=kind)
    points = np.column_stack([_MM * line.arcs.vertices, line.arcs.bulges])
    attributes = {"layer": line.layer}
    drawing.modelspace().add_lwpolyline(points, format="xyb", close=line.arcs.closed, dxfattribs=attributes)


@contextmanager
def _undated() -> Iterator[None]:
    """Within, ezdxf writes fixed dates and ids instead of those of the moment; the setting is global."""
    from ezdxf._options import options

    with _LOCK:
        before = options.write_fixed_meta_data_for_testing
        options.write_fixed_meta_data_for_testing = True
        try:
            yield
        finally:
            options.write_fixed_meta_data_for_testing = before
