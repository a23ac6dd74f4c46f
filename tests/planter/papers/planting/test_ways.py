"""An optimum is the same whatever way the kernels run and however many cores there are."""

import json
import os
import subprocess
import sys

import pytest

from planter.kernels.backends import BACKENDS

JOBS = {
    "samples": ["wang2017", "--method", "ipopt", "--starts", "2", "--samples", "90"],
    "extremes": ["wang2017", "--method", "ipopt", "--starts", "1", "--samples", "refined"],
    "requirements": ["wang2017-wide", "--method", "ipopt", "--starts", "1", "--samples", "60"],
}
"""Searches of a few seconds, one for each way that a descent takes."""


def optimum(job: str, way: str, cores: int) -> dict:
    """The result of a search, told by the command."""
    allowed = sorted(os.sched_getaffinity(0))[:cores]
    done = subprocess.run(
        [sys.executable, "-m", "planter", "optimise", *JOBS[job], "--json"],
        env={**os.environ, "PLANTER_KERNELS": way},
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        check=True,
        preexec_fn=lambda: os.sched_setaffinity(0, allowed),
    )
    result: dict = json.loads(done.stdout)
    return result


@pytest.mark.long
@pytest.mark.parametrize("job", JOBS)
def test_ways_and_cores_agree(job: str) -> None:
    first, *other_results = [
        optimum(job, way, cores) for way, cores in zip(BACKENDS, (2, 1, 2), strict=True)
    ]
    for other in other_results:
        assert other["objective"] == pytest.approx(first["objective"], rel=1e-9)
        assert other["certificate"]["kkt_residual"] < 1e-6
        assert other["certificate"]["agreeing_starts"] == first["certificate"]["agreeing_starts"]
        for name, value in first["design"].items():
            assert other["design"][name] == pytest.approx(value, rel=1e-6, abs=1e-6)
