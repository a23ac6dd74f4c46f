"""Adams: a command file that makes a spline over time of each quantity, for AKISPL and CUBSPL in functions.

Commands as the reference of Adams View has them: `data_element create spline` with `spline_name`, `comments`, `x`, `y`,
`linear_extrapolate`. Numbers are in millimetre, newton, degree, second.
"""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence

from planter.interchange.tables.motion import DICTIONARY, Motion, PlacedColumn, dictionary, in_millimetres

NUMBERS = 4
"""How many numbers stand in a line."""
WIDTH = 110


def files(motion: Motion) -> dict[str, bytes]:
    """`motion.cmd` and the dictionary of its splines."""
    columns = [in_millimetres(column, f"{motion.name}_{column.name}") for column in motion.columns[1:]]
    notes = (*motion.notes, "Units: mm, N, N mm, deg, s.")
    lines = [f"! {line}" for note in notes for line in textwrap.wrap(note, WIDTH)]
    time = motion.time.tolist()
    for column in columns:
        lines += ["!", *_spline(column, time)]
    text = "\n".join(lines) + "\n"
    return {"motion.cmd": text.encode("ascii", "replace"), DICTIONARY: dictionary("spline", motion.notes, columns)}


def _spline(spline: PlacedColumn, time: Sequence[float]) -> Iterator[str]:
    meaning = spline.column.meaning.replace('"', "'")
    yield "data_element create spline &"
    yield f"   spline_name = {spline.place} &"
    yield f'   comments = "{meaning} [{spline.unit}] over time [s]" &'
    yield from _numbers("x", time)
    yield from _numbers("y", spline.values.tolist())
    yield "   linear_extrapolate = no"


def _numbers(name: str, values: Sequence[float]) -> Iterator[str]:
    """Numbers with all their digits, in lines that go on."""
    for first in range(0, len(values), NUMBERS):
        part = ", ".join(f"{value:.16E}" for value in values[first : first + NUMBERS])
        head = f"   {name} = " if first == 0 else "      "
        yield f"{head}{part}{',' if first + NUMBERS < len(values) else ''} &"
