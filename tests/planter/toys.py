"""Jobs that tests can count by hand."""

import os
import signal
import time
from collections.abc import Callable
from pathlib import Path

from planter.errors import ComputationError, GeometryError, NotFiniteError

ERRORS = {
    "geometry": GeometryError("a cusp at 3 deg"),
    "computation": ComputationError("no root"),
    "not finite": NotFiniteError("force", "rows", 2, 5),
    "program": ValueError("a bug"),
}


def prepare_squares(
    fatal: int = -1, mark: str = "", wait_s: float = 0.0
) -> Callable[[int | str], object]:
    """Return the function that squares a number, or raises the error of a name.

    At the number `fatal` the process is killed, only once if `mark` names a file; it waits a while
    before any number.
    """

    def run(job: int | str) -> object:
        if job == "function":
            return run  # of which no pickle can be made
        if isinstance(job, str):
            raise ERRORS[job]
        if job == fatal and not (mark and Path(mark).exists()):
            if mark:
                Path(mark).touch()
            os.kill(os.getpid(), signal.SIGKILL)
        if mark:
            Path(mark).touch()
        time.sleep(wait_s)
        print("what a job prints goes nowhere")
        return job**2 / 3

    return run
