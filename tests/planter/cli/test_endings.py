"""How a call ends when it cannot end well: a signal at any time, standard output that takes
nothing.
"""

import json
import os
import signal
import subprocess
import sys
import time
from itertools import product
from pathlib import Path

import pytest

from tests.support.sampled import sampled

pytestmark = pytest.mark.fault
ROOT = Path(__file__).parents[3]
SIMULATE = (sys.executable, "-m", "planter", "simulate", "wang2017", "--json")
SLOW_IMPORT = """
import os, signal, sys, types
from planter.cli import main

class Loader:
    def find_spec(self, name, path=None, target=None):
        if name == "planter.cli.app":
            os.kill(os.getpid(), int(sys.argv.pop()))
            raise ImportError("as a module that swallows the interrupt does")

sys.meta_path.insert(0, Loader())
main()
"""


def _hears_interrupts() -> None:
    """A process in the background of a script is started deaf to them."""
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_signal_during_imports_ends_in_a_single_line(number: signal.Signals, code: int) -> None:
    done = subprocess.run(
        [sys.executable, "-c", SLOW_IMPORT, "simulate", "wang2017", "--json", str(int(number))],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
        preexec_fn=_hears_interrupts,
    )
    assert (done.returncode, done.stderr) == (code, "planter: interrupted\n")
    assert json.loads(done.stdout) == {
        "error": {"name": "Interrupted", "message": "interrupted"},
        "partial": None,
    }


BETWEEN = """
import os, sys, time
from planter import cli
from planter.cli import app

def library(standalone_mode):
    try:
        os.kill(os.getpid(), int(sys.argv.pop()))
        time.sleep(5)
    except KeyboardInterrupt:
        return 130

app.build_application = lambda: library
cli.main()
"""
"""What the command-line library does with a signal that comes outside a command."""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_signal_outside_a_command_is_reported(number: signal.Signals) -> None:
    done = subprocess.run(
        [sys.executable, "-c", BETWEEN, "--json", str(int(number))],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
        preexec_fn=_hears_interrupts,
    )
    assert (done.returncode, done.stderr) == (128 + number, "planter: interrupted\n")
    assert json.loads(done.stdout)["error"]["name"] == "Interrupted"


BEGUN = """
import sys
from planter import cli
print("begun", file=sys.stderr, flush=True)
cli.main()
"""
"""Before that Python itself is what a signal meets."""


@pytest.mark.parametrize(
    ("number", "delay"),
    sampled(
        [(signal.SIGINT, 0.3)],
        product((signal.SIGINT, signal.SIGTERM), (0.1, 0.3, 0.6)),
    ),
)
def test_signal_at_any_time_leaves_a_single_object(number: signal.Signals, delay: float) -> None:
    call = subprocess.Popen(
        [sys.executable, "-c", BEGUN, *SIMULATE[3:]],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=_hears_interrupts,
    )
    assert call.stderr is not None
    assert call.stderr.readline() == "begun\n"
    time.sleep(delay)
    call.send_signal(number)
    out, err = call.communicate(timeout=60)
    if call.returncode == 0:
        assert (err, "support_force" in json.loads(out)) == ("", True)
    else:
        assert (call.returncode, err) == (128 + number, "planter: interrupted\n")
        assert json.loads(out)["error"]["name"] == "Interrupted"


@pytest.mark.parametrize(
    ("number", "code"),
    [(signal.SIGINT, 130), pytest.param(signal.SIGTERM, 143, marks=pytest.mark.long)],
)
def test_interrupted_search_returns_best_design(
    number: signal.Signals, code: int, tmp_path: Path
) -> None:
    search = subprocess.Popen(
        [
            sys.executable,
            "-m",
            "planter",
            "optimise",
            "wang2017",
            "--method",
            "ga",
            "--json",
            "--out",
            str(tmp_path),
        ],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=_hears_interrupts,
    )
    assert search.stderr is not None
    while "generation 20 of 200" not in search.stderr.readline():  # steps before it may be reported
        assert search.poll() is None
    search.send_signal(number)
    out, err = search.communicate(timeout=30)
    assert search.returncode == code
    assert "Traceback" not in err
    result = json.loads(out)
    assert result["error"]["name"] == "Interrupted"
    assert result["partial"]["objective"] < result["partial"]["start_objective"]
    assert json.loads((tmp_path / "summary.json").read_text())["interrupted"] is True


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no device that is always full")
@pytest.mark.parametrize(
    "arguments", [("simulate", "wang2017"), ("simulate", "wang2017", "--json"), ("--help",)]
)
def test_full_standard_output_is_reported_in_a_single_line(arguments: tuple[str, ...]) -> None:
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "planter", *arguments],
            cwd=ROOT,
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
    assert done.returncode == 1
    assert (
        done.stderr
        == "planter: standard output: this cannot be written (No space left on device)\n"
    )


def test_closed_reader_is_not_an_error() -> None:
    read, write = os.pipe()
    os.close(read)
    done = subprocess.run(
        SIMULATE, cwd=ROOT, stdout=write, stderr=subprocess.PIPE, text=True, check=False
    )
    os.close(write)
    assert (done.returncode, done.stderr) == (1, "")


@pytest.mark.long
def test_a_terminal_of_ascii_gets_every_table() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "planter", "audit", "wang2017"],
        cwd=ROOT,
        capture_output=True,
        check=False,
        env={**os.environ, "PYTHONIOENCODING": "ascii"},
    )
    assert (done.returncode, done.stderr) == (0, b"")
    assert done.stdout.isascii()


LONG_CALL = """
import sys
import casadi as ca
from planter.kernels.backends import defer_interrupt
from planter.progress import name_step
from planter.report import process

process.listen_signals()
matrix = ca.SX.sym("A", 11, 11)  # minutes, within one call of compiled code
with name_step("expanding minors"):
    call = lambda: ca.det(matrix)
    defer_interrupt(call) if sys.argv.pop() == "deferred" else call()
"""
GRACE_S = 2.0
"""Largest time between a Ctrl-C and the end [s], on a machine that is not busy; it is given five
times as much here.
"""


@pytest.mark.parametrize(
    ("number", "code", "way"),
    sampled(
        [(signal.SIGINT, 130, "deferred")],
        [
            (number, 128 + number, way)
            for number in (signal.SIGINT, signal.SIGTERM)
            for way in ("called", "deferred")
        ],
    ),
)
def test_call_of_compiled_code_ends_soon_after_a_signal(
    number: signal.Signals, code: int, way: str
) -> None:
    """What takes long says what it does before."""
    call = subprocess.Popen(
        [sys.executable, "-c", LONG_CALL, "--json", way],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=_hears_interrupts,
    )
    assert call.stderr is not None
    assert "expanding minors" in call.stderr.readline()
    begin = time.monotonic()
    call.send_signal(number)
    out, err = call.communicate(timeout=60)
    assert time.monotonic() - begin < 5 * GRACE_S
    assert (call.returncode, err) == (code, "planter: interrupted\n")
    assert json.loads(out)["error"]["name"] == "Interrupted"
