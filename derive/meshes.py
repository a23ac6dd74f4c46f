"""Gears of a user's own statement that mesh: the pitch curves that their motion has, for those who cut them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import sympy as sp
from sympy import Expr

from .model import ClosedForm, Let, Step, let, needed, sorted_steps
from .quantity import Quantity, Vector, word

MESHES, PLACES = "meshes", "places"
"""The functions of all meshes of a statement, and of where the points of its bodies are."""
Packed = Vector | Quantity


@dataclass(frozen=True)
class Mesh:
    """Two gears that touch on their line of centres, beside each other.

    ``line`` [rad] is the direction from the inner gear's centre to the outer's, which is at ``centre`` [m]. ``polar``
    [rad] are the directions of the pitch point in the frames of both gears, ``radii`` [m] its distances from their
    centres, inner gear first.
    """

    tag: str
    gears: tuple[str, str]
    line: Expr
    centre: tuple[Expr, Expr]
    polar: tuple[Expr, Expr]
    radii: tuple[Expr, Expr]

    def lets(self) -> list[Let]:
        """Return ``mesh_TAG_x``, ``_y``, ``_line``, and of each gear ``_polar_1`` and ``_r_1``."""
        outer = self.gears[1]
        told = {
            "x": (self.centre[0], "m", f"centre of {outer}, x"),
            "y": (self.centre[1], "m", f"centre of {outer}, y"),
            "line": (self.line, "rad", f"direction from the centre of {self.gears[0]} to that of {outer}"),
        }
        for number, gear, polar, radius in zip((1, 2), self.gears, self.polar, self.radii, strict=True):
            told[f"polar_{number}"] = polar, "rad", f"direction of the pitch point in the frame of {gear}"
            told[f"r_{number}"] = radius, "m", f"pitch radius of {gear}"
        return [
            let(Quantity(f"mesh_{self.tag}_{name}", unit, meaning, "own"), sp.sympify(expr))
            for name, (expr, unit, meaning) in told.items()
        ]

    def places(self) -> list[Let]:
        """Return ``x_GEAR__POINT`` and its like [m] of both centres, of the pitch point, and of a mark on each gear."""
        along = sp.cos(self.line), sp.sin(self.line)
        distance = self.radii[0] + self.radii[1]
        inner = tuple(c - distance * a for c, a in zip(self.centre, along, strict=True))
        pitch = tuple(c + self.radii[0] * a for c, a in zip(inner, along, strict=True))
        found = []
        ways = self.line - self.polar[0], self.line + sp.pi - self.polar[1]
        for gear, centre, way, radius in zip(self.gears, (inner, self.centre), ways, self.radii, strict=True):
            mark = centre[0] + radius * sp.cos(way), centre[1] + radius * sp.sin(way)
            for point, place in (("centre", centre), ("pitch_point", pitch), ("mark", mark)):
                for axis, coordinate in zip("xy", place, strict=True):
                    meaning = f"{point.replace('_', ' ')} of {gear}, {axis}"
                    found.append(
                        let(Quantity(f"{axis}_{word(gear)}__{point}", "m", meaning, "own"), sp.sympify(coordinate))
                    )
        return found


def build_function(
    name: str, lets: Iterable[Let], inputs: Sequence[Packed], before: Sequence[Step]
) -> tuple[ClosedForm, ...]:
    """Return the function of some steps from what a lane takes; nothing where there is none.

    ``before`` are steps that they may need.
    """
    steps = list(lets)
    if not steps:
        return ()
    outputs = Vector(name, tuple(step.symbol for step in steps))
    return (ClosedForm(name, tuple(inputs), sorted_steps(needed((*before, *steps), frozenset(outputs))), outputs),)
