"""Jobs that tests can count by hand."""

import os
import signal
import time
from pathlib import Path

import numpy as np

from planter.errors import ComputationError
from planter.kernels import Array


class Squares:
    """Row i holds i and i squared.

    Before a chunk that begins at `fatal`, the process is killed once.
    """

    width = 2

    def __init__(
        self, rows: int, fatal: int = -1, mark: str = "", wrong: int = -1, wait: float = 0
    ) -> None:
        self.rows, self.fatal, self.mark, self.wrong, self.wait = rows, fatal, mark, wrong, wait

    def chunk(self, start: int, stop: int, threads: int) -> Array:
        if start == self.wrong:
            raise ComputationError("row 3 has no square")
        if start == self.fatal and not (self.mark and Path(self.mark).exists()):
            if self.mark:
                Path(self.mark).touch()
            os.kill(os.getpid(), signal.SIGKILL)
        time.sleep(self.wait)
        rows = np.arange(start, stop, dtype=float)
        return np.column_stack([rows, rows**2])
