"""A target: a language that models and pitch curves are written in. Each stands in one file of ``targets``."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from ..discovery import modules, offered
from ..gearing.pitch_curve import PitchCurve
from ..model import System
from ..quantity import reserve
from . import targets
from .text import Emitted


@dataclass(frozen=True)
class Target:
    """A language: the place of its files, such as ``array/{name}.py``, and the texts of a model and of a pitch curve.

    ``reserved`` are names that the texts need for themselves, so that no quantity can have them.
    """

    name: str
    place: str
    reserved: frozenset[str]
    model: Callable[[System, Sequence[Emitted]], str]
    curve: Callable[[PitchCurve, Sequence[Emitted]], str]

    def __post_init__(self) -> None:
        reserve(self.name, self.reserved)

    def path(self, name: str) -> str:
        """Where the file of a model or a curve goes, inside the generated folder."""
        return self.place.format(name=name)


def built_in() -> list[Target]:
    """The languages whose files stand in ``targets``."""
    return offered(modules(targets), "TARGET")
