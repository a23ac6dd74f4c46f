"""Results of commands and calls: attributes are the keys of the JSON, in their order and with their units."""

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

    A field with the default None is an optional key, left out if it is None. Any other None is null.
    """

    __pydantic_config__: ClassVar[ConfigDict] = {"extra": "forbid"}

    def table(self) -> dict[str, Any]:
        """Return the record as in its JSON: dicts, lists, texts, numbers in the units of their keys."""
        values = ((field, getattr(self, field.name)) for field in fields(self))
        return {field.name: _plain(value) for field, value in values if field.default is MISSING or value is not None}

    @classmethod
    def read(cls, table: Mapping[str, Any]) -> Self:
        """Build a record from its `table` or its JSON. Raises ValueError for other keys or types."""
        from pydantic import TypeAdapter

        return TypeAdapter(cls).validate_python(table)

    def to_frame(self, rows: str | None = None) -> DataFrame:
        """Return a list of this record as a table of pandas, columns in the units of their names.

        `rows` is the key of the list, by default the first list of rows. Raises InputError if there is no such list, or
        if pandas is not installed (`pip install planter[notebook]`).
        """
        return frames.frame(type(self).__name__, self.table(), rows)

    def _repr_html_(self) -> str:
        """Return the record as HTML for notebooks."""
        title = (type(self).__doc__ or "").partition("\n")[0].partition(";")[0]
        return html.record(title.replace("`", "").rstrip("."), self.table())


def _plain(value: Any) -> Any:
    if isinstance(value, Record):
        return value.table()
    if isinstance(value, Mapping):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return value
