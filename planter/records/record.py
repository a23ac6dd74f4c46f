"""What commands and calls find: attributes are the keys of a command's JSON, in their order and with their units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, dataclass, fields
from typing import TYPE_CHECKING, Any, ClassVar, Self

from planter.records import frames, html

if TYPE_CHECKING:
    from pandas import DataFrame
    from pydantic import ConfigDict


@dataclass(frozen=True)
class Record:
    """A result, or a part of one.

    A field whose default is None is a key that may be missing: it is left out while it is None. Any other None is null.
    """

    __pydantic_config__: ClassVar[ConfigDict] = {"extra": "forbid"}

    def table(self) -> dict[str, Any]:
        """The record as its JSON has it: dicts, lists, numbers in the units that their keys end in, texts."""
        values = ((field, getattr(self, field.name)) for field in fields(self))
        return {field.name: _plain(value) for field, value in values if field.default is MISSING or value is not None}

    @classmethod
    def read(cls, table: Mapping[str, Any]) -> Self:
        """The record that `table` gives, or that its JSON has. Raises ValueError for keys and types of another."""
        from pydantic import TypeAdapter

        return TypeAdapter(cls).validate_python(table)

    def to_frame(self, rows: str | None = None) -> DataFrame:
        """The rows of a list of this record as a table of pandas, columns in the units that their names end in.

        `rows` names the list; without it the first list of rows is meant. Raises InputError where there is none, and
        where pandas is missing (`planter[notebook]` brings it).
        """
        return frames.frame(type(self).__name__, self.table(), rows)

    def _repr_html_(self) -> str:
        """The record as a notebook shows it."""
        said = (type(self).__doc__ or "").partition("\n")[0].partition(";")[0]
        return html.record(said.replace("`", "").rstrip("."), self.table())


def _plain(value: Any) -> Any:
    if isinstance(value, Record):
        return value.table()
    if isinstance(value, Mapping):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return value
