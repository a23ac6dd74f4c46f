"""What is known of a planting device at a carrier angle: names, units and meanings, from the sidecar of its model."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from planter.files import units


@dataclass(frozen=True)
class Quantity:
    """A quantity of side 1, of side 2, half a turn behind, or, with side 0, of both together.

    `name` is a plain word, that of the equations, on side 2 with `_2` behind it; `unit` its SI unit; `shown` its key in
    tables, which ends in the unit there.
    """

    name: str
    unit: str
    shown: str
    meaning: str
    source: str
    side: int


def quantities(sidecar: Mapping[str, Any]) -> list[Quantity]:
    """Those of side 1, those of side 2, those of both, in the order of `Device.cycle`."""
    vectors = sidecar["vectors"]
    return [*_of(vectors["side"], 1), *_of(vectors["side"], 2), *_of(vectors["totals"], 0)]


def keys(entries: Sequence[Mapping[str, str]]) -> list[str]:
    """Keys of a vector's entries in tables, each ending in the unit that is shown."""
    return [entry.get("shown") or units.key(entry["name"], entry["unit"]) for entry in entries]


def second(key: str) -> str:
    """The key of a quantity on side 2.

    >>> second("F_B1x_N"), second("ratio")
    ('F_B1x_2_N', 'ratio_2')
    """
    suffix = units.suffix(key)
    return f"{key.removesuffix(suffix)}_2{suffix}"


def _of(entries: Sequence[Mapping[str, str]], side: int) -> Iterator[Quantity]:
    for entry, key in zip(entries, keys(entries), strict=True):
        if side == 2:
            yield Quantity(f"{entry['name']}_2", entry["unit"], second(key), entry["meaning"], entry["source"], side)
        else:
            yield Quantity(entry["name"], entry["unit"], key, entry["meaning"], entry["source"], side)
