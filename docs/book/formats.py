"""The page of file formats: what users hand in, what commands write, and the columns of CSV files."""

from __future__ import annotations

from itertools import groupby

from book.keys import cell
from planter.cli import dictionary

HEAD = """\
# File formats

Text is UTF-8. Names of numbers end in their unit. A CSV has one header; columns are separated by commas, with points
for decimals, or by semicolons or tabs, where decimals may have commas too. Lines that begin with `#` say what the file
is and which versions wrote it. Numbers that commands write read back to the same bits.

## What is handed in

| file | for | header or tables |
|---|---|---|
| machine, TOML | most commands | [keys](keys.md) |
| poses, TOML | `design synthesise` | `[[pose]]` with `x_mm`, `y_mm`, `phi_deg` |
| angle curve, CSV | `design train` | `carrier_deg,relative_deg`, a closed turn |
| path of a tip, CSV | `design pickup` | `x_mm,y_mm`, closed, in the order of a carrier that turns anticlockwise |
| points that a path must pass, CSV | `[requirements]`, `[tip_path]` | `x_mm,y_mm,tube_mm` |
| pitch curve, CSV | `gears --curve` | `polar_deg,radius_mm`, a closed turn |
| runs of a field test, CSV | `design clutch field` | a column a factor, a column a response; `... plan` writes one |
| measured curve, CSV | `calibrate --data` | any names, separators and units, as told or found |
| plan of a sweep, TOML | `sweep` | [sweeps](../sweeps.md) |
| tolerances, TOML | `tolerance` | [tolerances](../tolerances.md) |
| mechanism or paper of your own, Python | `derive`, `audit` | [the words that they are stated with](mechanism.md) |
| printed numbers, TOML | `audit --numbers` | `planter audit --help` |

## What is written

`--out DIR` writes `summary.json` (the object that `--json` prints), `report.html` (one page that fetches nothing),
figures as SVG and PNG in `figures/`, CSV files, and what the command is for: `optimum.toml` (a machine file), DXF,
STEP, STL, C, `.fmu`. A later command into the same folder removes what an earlier one wrote there and this one did not,
unless somebody changed it since. The rows of a sweep are also there as Parquet.

## Columns of CSV files

Most are symbols and keys of results, with their unit, which `planter about explain` explains, or the same with `_2`
for side 2 of a planting device; these are the others.
"""


def page() -> str:
    """The page."""
    found = sorted(
        (one for one in dictionary.collect_meanings() if one.kind == "column"),
        key=lambda one: (one.machine, one.source),
    )
    parts = [HEAD]
    for machine, own in groupby(found, key=lambda one: one.machine):
        parts += [f"\n### {machine}\n", "| column | unit | meaning | of |", "|---|---|---|---|"]
        parts += [
            f"| `{one.name}` | {cell(one.unit)} | {cell(one.meaning)} | {cell(one.source)} |"
            for one in own
        ]
    return "\n".join(parts) + "\n"
