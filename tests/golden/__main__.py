"""Renew the record and print what differs: `python -m tests.golden [short|long|NAME ...]`, all
commands by default.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from tests.golden import record


def renew(names: list[str]) -> None:
    """Write the entries of these commands to kept.json, and print each line that differs from the
    record.
    """
    recorded = record.read_kept()
    commands = record.list_commands(is_long=False) | record.list_commands(is_long=True)
    for name in names:
        with TemporaryDirectory() as folder:
            entries = record.evaluate(commands[name], Path(folder))
        for line in record.compare(recorded.get(name, {}), entries, {}):
            print(f"{name}: {line}", flush=True)
        recorded[name] = entries
    lines = [f"{json.dumps(name)}: {json.dumps(recorded[name])}" for name in commands]
    record.KEPT.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")


def select(words: list[str]) -> list[str]:
    """Return the names of the commands that these words select."""
    groups = {
        "short": [*record.list_commands(is_long=False)],
        "long": [*record.list_commands(is_long=True)],
    }
    return [name for word in words or groups for name in groups.get(word, [word])]


if __name__ == "__main__":
    renew(select(sys.argv[1:]))
