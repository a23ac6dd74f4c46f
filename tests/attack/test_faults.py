"""Where a process cannot have what it wants: a disk, a home, a locale, its streams, the machine for
itself.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType

import pytest

from tests.support.structure import ROOT

pytestmark = pytest.mark.fault
SIMULATE = ("simulate", "wang2017", "--json", "--samples", "36")
SEARCH = ("optimise", "wang2017", "--json", "--method", "ipopt", "--starts", "1", "--samples", "36")
as_a_user = pytest.mark.skipif(
    not hasattr(os, "geteuid") or os.geteuid() == 0, reason="for root no folder is closed"
)
posix = pytest.mark.skipif(os.name != "posix", reason="no limits and no descriptors to close here")


def called(
    *arguments: str,
    python: tuple[str, ...] = (),
    variables: Mapping[str, str] = MappingProxyType({}),
    before: Callable[[], object] | None = None,
) -> subprocess.CompletedProcess[str]:
    """A process of its own, with nothing but what it needs in its env; `before` is called within
    it.
    """
    env = {
        name: os.environ[name]
        for name in ("PATH", "SYSTEMROOT", "TMPDIR", "TEMP")
        if name in os.environ
    }
    return subprocess.run(
        [sys.executable, *python, "-m", "planter", *arguments],
        capture_output=True,
        text=True,
        check=False,
        env=env | {"PYTHONPATH": str(ROOT), "PLANTER_KERNELS": "casadi-vm"} | dict(variables),
        preexec_fn=before,
    )


def list_messages(done: subprocess.CompletedProcess[str]) -> list[str]:
    """Return the lines on standard error without the step that a slow machine names."""
    return [line for line in done.stderr.splitlines() if line != "planter: computing the cycle"]


@pytest.fixture(scope="module")
def expected() -> str:
    """What a call says where nothing is wrong."""
    done = called(*SIMULATE)
    assert (done.returncode, list_messages(done)) == (0, [])
    return done.stdout


LOCALES = {
    "no home": {},
    "the C locale": {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"},
    "a locale that there is not": {"LC_ALL": "xx_XX.UTF-8", "LANG": "tr_TR"},
    "streams of ASCII": {"PYTHONIOENCODING": "ascii:strict"},
    "a hash seed": {"PYTHONHASHSEED": "20171"},
}


@pytest.mark.parametrize(
    "case", ["no home", *(pytest.param(c, marks=pytest.mark.long) for c in [*LOCALES][1:])]
)
def test_an_environment_makes_no_difference(case: str, expected: str) -> None:
    done = called(*SIMULATE, variables=LOCALES[case])
    assert (done.returncode, done.stdout, list_messages(done)) == (0, expected, [])


@pytest.mark.parametrize("flag", ["-O", pytest.param("-OO", marks=pytest.mark.long)])
def test_optimised_python_says_the_same(flag: str, expected: str) -> None:
    done = called(*SIMULATE, python=(flag, "-W", "error"))
    assert (done.returncode, done.stdout, list_messages(done)) == (0, expected, [])


@posix
@pytest.mark.long
@pytest.mark.parametrize("closed", [(0,), (1,), (2,), (0, 1, 2)])
def test_closed_streams_are_tolerated(closed: tuple[int, ...], tmp_path: Path) -> None:
    done = called(
        *SIMULATE, "--out", str(tmp_path), before=lambda: [os.close(stream) for stream in closed]
    )
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stderr
    assert json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))["samples"] == 36


@posix
@pytest.mark.parametrize("room", [4000, pytest.param(60_000, marks=pytest.mark.long)])
def test_full_disk_is_reported_in_a_single_line(room: int, tmp_path: Path) -> None:
    import resource

    def limited() -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (room, room))

    unspoiled = {
        "PYTHONDONTWRITEBYTECODE": "1"
    }  # the interpreter would leave compiled modules cut short
    done = called(*SIMULATE, "--out", str(tmp_path / "out"), variables=unspoiled, before=limited)
    assert done.returncode in (1, 2)
    messages = [line for line in done.stderr.splitlines() if line.startswith("planter: ")]
    assert messages
    assert "cannot be written" in messages[-1]
    assert "Traceback" not in done.stderr


@as_a_user
def test_read_only_folder_is_reported_in_a_single_line(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    done = called(*SIMULATE, "--out", str(tmp_path / "out"))
    tmp_path.chmod(0o700)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)


@pytest.mark.long
def test_eight_processes_agree(expected: str, tmp_path: Path) -> None:
    """In one folder, with one cache of compiled functions."""
    variables = {**os.environ, "PYTHONPATH": str(ROOT), "PLANTER_CACHE": str(tmp_path / "cache")}
    variables.pop("PLANTER_KERNELS", None)
    command = [sys.executable, "-m", "planter", *SIMULATE, "--out", str(tmp_path / "out")]
    running = [
        subprocess.Popen(
            command, env=variables, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE
        )
        for _ in range(8)
    ]
    ends = [(*process.communicate(timeout=300), process.returncode) for process in running]
    assert ends == [(expected, "", 0)] * 8
    assert (
        json.loads((tmp_path / "out" / "summary.json").read_text(encoding="utf-8"))["samples"] == 36
    )


@pytest.mark.long
def test_killed_search_restarts_in_same_folder(tmp_path: Path) -> None:
    command = [
        sys.executable,
        "-m",
        "planter",
        "optimise",
        "wang2017",
        "--json",
        "--out",
        str(tmp_path),
    ]
    first = subprocess.Popen(
        command, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    limit = time.monotonic() + 120
    while not (tmp_path / "summary.json").exists() and time.monotonic() < limit:
        time.sleep(0.05)
    first.kill()
    first.wait()
    assert json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))["finished"] is False
    done = called(*SEARCH, "--out", str(tmp_path))
    assert (done.returncode, "Traceback" in done.stderr) == (0, False)
    summary = json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))
    assert "finished" not in summary
    assert summary["objective"] == json.loads(done.stdout)["objective"]
    assert not [path for path in tmp_path.rglob("*") if path.suffix in (".tmp", ".part")]
