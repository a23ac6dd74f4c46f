"""A number that a statement gives: its value and bounds, as they were written."""

from dataclasses import dataclass
from decimal import Decimal


@dataclass(frozen=True)
class Datum:
    """A value in its shown unit as it was written, with bounds if it has any."""

    value: Decimal
    bounds: tuple[Decimal, Decimal] | None = None
