"""Every command gives the numbers of the record; `python -m tests.golden` renews it and prints what
differs.
"""

import re
from pathlib import Path

import pytest

from tests.golden import record

SHORT, LONG = record.list_commands(is_long=False), record.list_commands(is_long=True)
KEPT, TOLERANCES = record.read_kept(), record.read_tolerances()


@pytest.mark.usefixtures("blank_figures")
@pytest.mark.parametrize(
    "name", [*SHORT, *(pytest.param(name, marks=pytest.mark.long) for name in LONG)]
)
def test_command_gives_the_recorded_numbers(name: str, tmp_path: Path) -> None:
    entries = record.evaluate((SHORT | LONG)[name], tmp_path)
    assert not record.compare(KEPT[name], entries, TOLERANCES.get(name, {}))


def test_record_holds_every_command() -> None:
    assert KEPT.keys() == (SHORT | LONG).keys()
    assert TOLERANCES.keys() <= KEPT.keys()
    assert all(len(entries) > 2 for entries in KEPT.values())


def test_changed_number_key_and_text_are_noticed() -> None:
    entries = KEPT["wang2017.simulate"]
    key = next(key for key, value in entries.items() if isinstance(value, float) and abs(value) > 1)
    for changed in (
        entries | {key: entries[key] * (1 + 1e-11)},
        {name: entries[name] for name in entries if name != key},
        entries | {"surplus": 1.0},
    ):
        assert len(record.compare(entries, changed, {})) == 1
    assert record.compare(entries, entries | {key: entries[key] * (1 + 1e-13)}, {}) == []
    tolerant = {re.escape(key): {"relative": 1e-10, "reason": "rounding is amplified"}}
    assert record.compare(entries, entries | {key: entries[key] * (1 + 1e-11)}, tolerant) == []
    assert len(record.compare(entries, entries | {key: entries[key] * (1 + 1e-9)}, tolerant)) == 1
    text = next(key for key in KEPT["wang2017.export_c"] if key.endswith(".c"))
    assert record.compare(KEPT["wang2017.export_c"], KEPT["wang2017.export_c"] | {text: "0"}, {})


def test_long_lists_are_distinguished_by_order(tmp_path: Path) -> None:
    numbers = [float(i**2) for i in range(20)]
    swapped = [*numbers[:3], numbers[4], numbers[3], *numbers[5:]]
    first, second = (record.flatten({"x": x}, tmp_path) for x in (numbers, swapped))
    assert record.compare(first, second, {})
