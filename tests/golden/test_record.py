"""Every command gives the numbers that it gave before all mechanisms went through the engine."""

import json
import re
from pathlib import Path

import pytest

from tests.golden import record
from tests.support import own
from tests.support.cli import run

SHORT, LONG = record.list_commands(is_long=False), record.list_commands(is_long=True)
MECHANISMS = [path.stem for path in own.EXAMPLES.glob("*.py") if not path.stem.endswith("_paper")]
KEPT, REASONS = record.read_kept(), record.read_reasons()


def evaluate(words: list[str], folder: Path, monkeypatch: pytest.MonkeyPatch) -> record.Entries:
    monkeypatch.chdir(folder)
    names = [name for name in MECHANISMS if f"{{own}}/{name}.toml" in words]
    places = {"own": str(own.generated(names[0])) if names else "", "docs": str(own.EXAMPLES)}
    code, out, err = run(*(word.format(**places) for word in words), "--json")
    assert code == 0, err
    return record.flatten(json.loads(out), folder)


@pytest.mark.usefixtures("blank_figures")
@pytest.mark.parametrize("name", [*SHORT, *(pytest.param(name, marks=pytest.mark.long) for name in LONG)])
def test_command_gives_the_recorded_numbers(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    entries = evaluate((SHORT | LONG)[name], tmp_path, monkeypatch)
    reasons = REASONS.get(name, {})
    lines, used = record.compare(KEPT[name], entries, reasons)
    assert not lines
    assert used == {pattern for pattern, reason in reasons.items() if isinstance(reason, str)}, "unnecessary reasons"


def test_record_holds_every_command() -> None:
    assert KEPT.keys() == (SHORT | LONG).keys()
    assert REASONS.keys() <= KEPT.keys()
    assert all(len(entries) > 2 or any(key.endswith(".cu") for key in entries) for entries in KEPT.values())


def test_changed_number_key_and_text_are_noticed() -> None:
    entries = KEPT["wang2017.simulate"]
    key = next(key for key, value in entries.items() if isinstance(value, float) and abs(value) > 1)
    for changed in (
        entries | {key: entries[key] * (1 + 1e-11)},
        {name: entries[name] for name in entries if name != key},
    ):
        assert len(record.compare(entries, changed, {})[0]) == 1
        assert record.compare(entries, changed, {re.escape(key): "on purpose"}) == ([], {re.escape(key)})
    assert record.compare(entries, entries | {key: entries[key] * (1 + 1e-13)}, {}) == ([], set())
    tolerant = {re.escape(key): {"relative": 1e-10, "reason": "rounding is amplified"}}
    assert record.compare(entries, entries | {key: entries[key] * (1 + 1e-11)}, tolerant) == ([], set())
    assert len(record.compare(entries, entries | {key: entries[key] * (1 + 1e-9)}, tolerant)[0]) == 1
    text = next(key for key in KEPT["wang2017.export_c"] if key.endswith(".c"))
    assert record.compare(KEPT["wang2017.export_c"], KEPT["wang2017.export_c"] | {text: "0"}, {})[0]


def test_long_lists_are_distinguished_by_order(tmp_path: Path) -> None:
    numbers = [float(i**2) for i in range(20)]
    swapped = [*numbers[:3], numbers[4], numbers[3], *numbers[5:]]
    first, second = (record.flatten({"x": x}, tmp_path) for x in (numbers, swapped))
    assert record.compare(first, second, {})[0]
