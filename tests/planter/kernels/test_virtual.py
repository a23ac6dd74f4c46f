"""The virtual machine's memory: bounded, of each thread its own, and no lock that a fork would
inherit closed.
"""

import os
import subprocess
import sys
import threading
from collections import OrderedDict
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from planter.kernels import Array, Kernel, backends

ROOT = Path(__file__).parents[3]
COUNTS = range(100, 448, 4)


@pytest.fixture
def kernel() -> Kernel:
    phi, x = ca.SX.sym("phi"), ca.SX.sym("x", 50)
    outputs = [ca.sin(phi) * x]
    return Kernel(ca.Function("wave", [phi, x], outputs, ["phi", "x"], ["y"]), lanes=["phi"])


def called(kernel: Kernel, count: int) -> Array:
    return kernel(phi=np.linspace(0, 1, count), x=np.arange(50.0))["y"]


def list_calls(kernel: Kernel) -> OrderedDict[int, backends._Call]:
    return kernel._way._calls._kept  # type: ignore[attr-defined]


class TestWhatIsKept:
    def test_many_numbers_of_lanes_keep_no_more_than_the_bound(
        self, kernel: Kernel, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr(backends, "CACHE_BYTES", 3_000_000)
        for count in COUNTS:
            called(kernel, count)
        assert sum(call.bytes for call in list_calls(kernel).values()) <= 3_000_000
        assert list(list_calls(kernel)) == list(COUNTS)[-len(list_calls(kernel)) :]
        assert len(list_calls(kernel)) > 1

    def test_cache_without_bound_would_grow(
        self, kernel: Kernel, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr(backends, "CACHE_BYTES", 10**12)
        for count in COUNTS:
            called(kernel, count)
        assert len(list_calls(kernel)) == 87
        assert sum(call.bytes for call in list_calls(kernel).values()) > 3 * 3_000_000

    def test_last_entry_stays_at_any_size(
        self, kernel: Kernel, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr(backends, "CACHE_BYTES", 1)
        for count in (5, 7):
            called(kernel, count)
            assert list(list_calls(kernel)) == [count]

    def test_reused_entry_stays(self, kernel: Kernel, monkeypatch: pytest.MonkeyPatch) -> None:
        for count in (5, 6):
            called(kernel, count)
        monkeypatch.setattr(
            backends, "CACHE_BYTES", sum(call.bytes for call in list_calls(kernel).values()) + 10
        )
        called(kernel, 5)
        called(kernel, 4)
        assert list(list_calls(kernel)) == [5, 4]

    def test_a_thread_s_memory_ends_with_it(self, kernel: Kernel) -> None:
        called(kernel, 5)
        thread = threading.Thread(target=called, args=(kernel, 9))
        thread.start()
        thread.join()
        assert list(list_calls(kernel)) == [5]


def test_threads_compute_concurrently_in_separate_memory(kernel: Kernel) -> None:
    """All meet inside a call: with memory, or a lock, that they share they would not, or find
    another's numbers.
    """
    meeting = threading.Barrier(4, timeout=30)
    angles = np.random.default_rng(1).uniform(size=(4, 300))

    def run(phi: Array) -> Array:
        kernel(phi=phi, x=np.arange(50.0))
        call = kernel._way._calls[300]  # type: ignore[attr-defined]
        evaluate = call._run
        call._run = lambda: (meeting.wait(), evaluate(), meeting.wait())
        return kernel(phi=phi, x=np.arange(50.0))["y"]

    with ThreadPoolExecutor(4) as pool:
        results = list(pool.map(run, angles))
    for phi, y in zip(angles, results, strict=True):
        assert y == pytest.approx(np.outer(np.arange(50), np.sin(phi)), rel=1e-14)


FORK = """
import os, sys, threading
from functools import cached_property
import casadi as ca, numpy as np
from planter.kernels import Kernel, backends

class Lazy:
    def __init__(self, compute):
        self.compute = compute

    @cached_property
    def value(self):
        return self.compute()

x = ca.SX.sym("x")
kernel = Kernel(ca.Function("square", [x], [x**2], ["x"], ["y"]), lanes=["x"])
kernel(x=[1.0, 2.0])
inside, out = threading.Event(), threading.Event()

def wait():
    inside.set()
    out.wait()

def slow():
    {occupied}

thread = threading.Thread(target=slow)
thread.start()
inside.wait()
{before}
child = os.fork()
if child == 0:
    os._exit(0 if Lazy(dict).value == dict() and kernel(x=[1.0, 3.0, 4.0])["y"].tolist() == [[1.0, 9.0, 16.0]] else 3)
out.set()
thread.join()
sys.exit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
"""
IN_A_KERNEL = """
    kernel(x=[1.0, 2.0])
    kernel._way._calls[2]._run = wait
    kernel(x=[1.0, 2.0])"""
COMPUTING_A_PROPERTY = """
    Lazy(wait).value"""
PUTTING_TOGETHER = """
    with backends._BUILD_LOCK:
        wait()"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork")
@pytest.mark.parametrize(
    ("occupied", "before"),
    [
        (IN_A_KERNEL, ""),
        (COMPUTING_A_PROPERTY, ""),
        (PUTTING_TOGETHER, "threading.Timer(0.2, out.set).start()"),
    ],
    ids=["in a kernel", "computing a cached property", "putting a function together"],
)
def test_a_fork_while_another_thread_works(occupied: str, before: str) -> None:
    program = FORK.format(occupied=occupied, before=before)
    subprocess.run([sys.executable, "-c", program], cwd=ROOT, check=True, timeout=30)
