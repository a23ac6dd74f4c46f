"""LabVIEW measurement files, written after the published format in each layout.

Keys with values, segments with a cell for each channel, two where a channel has times of its own,
comments behind the columns of some rows.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from planter.kernels import Array

END = "***End_of_Header***"


@dataclass(frozen=True)
class Layout:
    """How a file is written: one of the format's layouts, and what it leaves open."""

    x_columns: str = "One"
    separator: str = "Tab"
    decimal: str = "."
    states_decimal: bool = True
    multi_headings: bool = True
    segments: int = 1
    channels: int = 2
    rows: int = 30
    comments: bool = False
    special: bool = False
    restarts: bool = False
    padded: bool = True
    steps: tuple[float, ...] = (0.002, 0.002)


def write_lvm(path: Path, layout: Layout) -> tuple[list[Array], list[Array]]:
    """Write a file; return times [s] and values of each channel over all segments."""
    sign = {"Tab": "\t", "Comma": ",", "Semicolon": ";"}[layout.separator]
    lines: list[str] = []

    def number(value: float) -> str:
        return f"{value:.9g}".replace(".", layout.decimal)

    def add(*cells: str) -> None:
        lines.append(sign.join(cells) + sign * layout.padded)

    def spread(key: str, cells: list[str]) -> None:
        gap = [""] if layout.x_columns == "Multi" else []
        add(key, *[part for cell in cells for part in (cell, *gap)])

    add("LabVIEW Measurement")
    for key, value in (
        ("Writer_Version", "2"),
        ("Reader_Version", "2"),
        ("Separator", layout.separator),
    ):
        add(key, value)
    if layout.states_decimal:
        add("Decimal_Separator", layout.decimal)
    add("Multi_Headings", "Yes" if layout.multi_headings else "No")
    add("X_Columns", layout.x_columns)
    add("Time_Pref", "Relative")
    add(END)
    add("")
    if layout.special:
        lines.extend(
            ["***Start_Special***", f"Channels{sign}99", "notes of a plug-in", "***End_Special***"]
        )
    times: list[list[float]] = [[] for _ in range(layout.channels)]
    values: list[list[float]] = [[] for _ in range(layout.channels)]
    for segment in range(layout.segments):
        begin = segment * layout.rows * 0.0021
        if segment == 0 or layout.multi_headings:
            everywhere = range(layout.channels)
            add("Channels", str(layout.channels))
            spread("Samples", [str(layout.rows)] * layout.channels)
            spread("Date", ["2026/02/28"] * layout.channels)
            clock = f"23:59:{59 + begin:.6f}" if 59 + begin < 60 else f"00:00:{begin - 1:09.6f}"
            spread("Time", [clock.replace(".", layout.decimal)] * layout.channels)
            if 59 + begin >= 60:
                lines[-2] = lines[-2].replace("2026/02/28", "2026/03/01")
            spread("Y_Unit_Label", ["N", "Volts", "mm"][: layout.channels])
            spread("X_Dimension", ["Time"] * layout.channels)
            spread("X0", [number(0.0 if layout.restarts else begin)] * layout.channels)
            spread("Delta_X", [number(layout.steps[i % 2]) for i in everywhere])
            add(END)
        titles = [f"Channel {i}" for i in range(layout.channels)]
        if layout.x_columns == "Multi":
            titles = [part for title in titles for part in ("X_Value", title)]
        else:
            titles = ["X_Value", *titles]
        lines.append(sign.join([*titles, "Comment"]))
        for row in range(layout.rows):
            cells = []
            for channel in range(layout.channels):
                since = row * layout.steps[channel % 2]
                times[channel].append(begin + since)
                value = round(np.sin(row + 3 * channel + segment) * 10 ** (channel - 1), 6)
                values[channel].append(value)
                stamp = number(since if layout.restarts else begin + since)
                if layout.x_columns == "Multi":
                    cells.append(stamp)
                elif channel == 0:
                    cells.append(stamp if layout.x_columns == "One" else "")
                cells.append(number(value))
            if layout.comments and row in (0, 7):
                cells.append("valve opened at 12")
            lines.append(sign.join(cells))
        lines.append("")
    path.write_bytes("\r\n".join(lines).encode("cp1252"))
    return list(map(np.array, times)), list(map(np.array, values))
