"""Renews the front that is kept: `python -m planter.planting.undisclosed`."""

from __future__ import annotations

import json
import sys
from pathlib import Path

from planter.planting.file import load
from planter.planting.printed.attainable import PAPER, table
from planter.planting.undisclosed.front import KEPT, key, sought

machine, own = load(PAPER), table()
found = {"key": key(machine, own), **sought(machine, own, lambda at: print(at, file=sys.stderr))}
Path(__file__).with_name(KEPT).write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
