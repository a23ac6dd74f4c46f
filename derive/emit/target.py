"""A target: a language that models and pitch curves are written in. Each stands in one file of ``targets``."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from ..gearing.pitch_curve import PitchCurve
from ..model import System
from .text import Emitted


@dataclass(frozen=True)
class Target:
    """A language: the place of its files, such as ``array/{name}.py``, and the texts of a model and of a pitch curve.

    ``reserved`` names what a quantity must not be called, because the texts need the name.
    """

    name: str
    place: str
    reserved: frozenset[str]
    model: Callable[[System, Sequence[Emitted]], str]
    curve: Callable[[PitchCurve, Sequence[Emitted]], str]

    def path(self, name: str) -> str:
        """Where the file of a model or a curve goes, inside the generated folder."""
        return self.place.format(name=name)
