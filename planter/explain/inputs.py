"""Keys of the files that users hand in, by the classes that check them: unit, section, what is allowed."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, get_args, get_origin

from annotated_types import Ge, Gt, Le, Lt
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from planter import rooms
from planter.explain.results import Meaning
from planter.files import paths, schema, units
from planter.files.document import Document
from planter.files.fields import LARGEST

BOUNDS = {Gt: ("greater than", "gt"), Ge: ("at least", "ge"), Lt: ("less than", "lt"), Le: ("at most", "le")}
TIGHTEST: dict[str, Callable[..., float]] = {"greater than": max, "at least": max, "less than": min, "at most": min}


def found(symbols: Mapping[tuple[str, str], str]) -> Iterator[Meaning]:
    """Every key that holds a value; `symbols` has meanings by room and by where a symbol's value stands in the file."""
    for module in rooms.brought("file"):
        room = module.__name__.split(".")[-2]
        for kind in vars(module).values():
            if isinstance(kind, type) and issubclass(kind, Document) and kind is not Document:
                yield from _of_section(room, kind, "", symbols)


def _of_section(
    room: str, kind: type[BaseModel], before: str, symbols: Mapping[tuple[str, str], str]
) -> Iterator[Meaning]:
    for key, field in schema.fields(kind).items():
        path = f"{before}.{key}" if before else key
        inner = schema.section(field.annotation)
        if inner is not None:
            yield from _of_section(room, inner, path, symbols)
        else:
            yield _meaning(room, kind, path, field, symbols)


def _meaning(
    room: str, kind: type[BaseModel], path: str, field: FieldInfo, symbols: Mapping[tuple[str, str], str]
) -> Meaning:
    told = symbols.get((room, path)) or "; ".join(
        text for (owner, place), text in symbols.items() if owner == room and place.startswith(f"{path}[")
    )
    section = " ".join((kind.__doc__ or "").split()).partition(". ")[0].rstrip(".")
    return Meaning(
        name=paths.last_part(path),
        kind="file key",
        machine=room,
        unit=units.unit(path),
        meaning=told or section,
        source=f"[{path.rpartition('.')[0]}]" if "." in path else "top of the file",
        key=path,
        allowed=_allowed(field),
    )


def _allowed(field: FieldInfo) -> str | None:
    """The tightest bounds that the field's type sets, and whether it may be left out."""
    bounds = list(_bounds(field.metadata, field.annotation))
    told = [
        f"{words} {tightest(value for word, value in bounds if word == words):g}"
        for words, tightest in TIGHTEST.items()
        if any(word == words and abs(value) < LARGEST for word, value in bounds)
    ]
    if not field.is_required():
        told.append("may be left out")
    return ", ".join(told) or None


def _bounds(metadata: Sequence[Any], annotation: Any) -> Iterator[tuple[str, float]]:
    """Kind and value of each bound in a type, those of a list's items among them."""
    for one in metadata:
        if type(one) in BOUNDS:
            words, name = BOUNDS[type(one)]
            yield words, float(getattr(one, name))
        elif isinstance(one, FieldInfo):
            yield from _bounds(one.metadata, None)
    if get_origin(annotation) is not None:
        for inner in get_args(annotation):
            yield from _bounds(getattr(inner, "__metadata__", ()), getattr(inner, "__origin__", inner))
