"""Simulink: a MAT-file for the block From File.

As the block's reference has it: one matrix of doubles, the time in its first row, a signal in each other row. From
Workspace takes its transpose.
"""

from __future__ import annotations

import io

import numpy as np
from scipy.io import savemat

from planter.interchange.tables.motion import DICTIONARY, Motion, dictionary, in_si

TEXT_BYTES = 116
"""What a MAT-file of version 5 begins with: text, in which SciPy puts the date."""


def files(motion: Motion) -> dict[str, bytes]:
    """`motion.mat` with the matrix `motion` in SI units, and the dictionary of its rows."""
    columns = [in_si(column, str(row)) for row, column in enumerate(motion.columns, 1)]
    stream = io.BytesIO()
    savemat(stream, {"motion": np.array([column.values for column in columns])}, format="5")
    text = f"MATLAB 5.0 MAT-file, {motion.name}, rows: see {DICTIONARY}".encode("ascii", "replace")[:TEXT_BYTES]
    content = text.ljust(TEXT_BYTES) + stream.getvalue()[TEXT_BYTES:]
    return {"motion.mat": content, DICTIONARY: dictionary("row", motion.notes, columns)}
