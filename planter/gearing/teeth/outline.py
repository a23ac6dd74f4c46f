"""What a toothed outline is: exact pieces that end where the next begins, which files are written from."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, Protocol

from planter.kernels import Array

Kind = Literal["tip", "flank", "fillet", "root", "wall", "convex arc", "concave arc", "topping"]
"""The last four are those of incomplete gears."""


class Piece(Protocol):
    """A smooth piece of an outline by a parameter s that runs from 0 to 1 in the outline's direction, anticlockwise.

    `tooth` is the number of the tooth; a root has that of the tooth before it. `side` is +1 on the flank that ends a
    tooth in the outline's direction and on its fillet, -1 on the one that begins it, 0 for tip and root.
    """

    @property
    def kind(self) -> Kind: ...

    @property
    def tooth(self) -> int: ...

    @property
    def side(self) -> int: ...

    def at(self, s: Array) -> Array:
        """Points (n, 2) [m]."""

    def tangent(self, s: Array) -> Array:
        """Unit tangents (n, 2) in the outline's direction."""

    def curvature(self, s: Array) -> Array:
        """Signed curvature (n,) [1/m], positive where the outline bends to the left."""


@dataclass(frozen=True)
class Outline:
    """The closed outline of a gear, in the frame of its axis: each piece ends where the next begins.

    `centre` is the gear's axis (0, 0) or where an assembly puts it [m]; `pitch` gives points (n, 2) [m] of the closed
    pitch curve, by a parameter (n,) that runs from 0 to 1.
    """

    name: str
    pieces: tuple[Piece, ...]
    centre: tuple[float, float]
    pitch: Callable[[Array], Array]
