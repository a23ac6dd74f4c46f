"""SolidWorks Motion: data points of motors and forces, a file for each quantity.

As the program's help has it: one point a line, time and value, with a comma between them; there is no header. The name
of a file ends in the unit.
"""

from __future__ import annotations

from planter.interchange.tables.motion import DICTIONARY, Motion, dictionary, in_key_unit


def files(motion: Motion) -> dict[str, bytes]:
    """A file for each quantity, and the dictionary of all."""
    columns = [in_key_unit(column, f"{column.key}.csv") for column in motion.columns[1:]]
    time = motion.time.tolist()
    points = {
        column.place: "".join(f"{t!r},{v!r}\n" for t, v in zip(time, column.values.tolist(), strict=True)).encode()
        for column in columns
    }
    return points | {DICTIONARY: dictionary("file", motion.notes, columns)}
