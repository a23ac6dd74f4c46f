"""A target: a language that models and pitch curves are written in. Each stands in one file of ``targets``."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
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

    ``reserved`` are names that the texts need for themselves, so that no quantity can have them. A target
    ``on_request`` is written, and keeps its names, where it is asked for alone.
    """

    name: str
    place: str
    reserved: frozenset[str]
    model: Callable[[System, Sequence[Emitted]], str]
    curve: Callable[[PitchCurve, Sequence[Emitted]], str]
    on_request: bool = False

    def __post_init__(self) -> None:
        if not self.on_request:
            self.reserve()

    def reserve(self) -> None:
        """Keep its names from quantities."""
        reserve(self.name, self.reserved)

    def path(self, name: str) -> str:
        """Where the file of a model or a curve goes, inside the generated folder."""
        return self.place.format(name=name)


def built_in() -> list[Target]:
    """The languages whose files stand in ``targets``."""
    return offered(modules(targets), "TARGET")


def chosen(known: Iterable[Target], asked: Collection[str] = ()) -> list[Target]:
    """The languages that are always written, and those that are asked for by name, whose names are kept from now on.

    Raises ValueError where none has a name that is asked for.
    """
    by_name = {target.name: target for target in known}
    if unknown := sorted(set(asked) - by_name.keys()):
        raise ValueError(f"no target is called {unknown[0]}; there are {', '.join(sorted(by_name))}")
    found = [target for target in by_name.values() if target.name in asked or not target.on_request]
    for target in found:
        target.reserve()
    return found
