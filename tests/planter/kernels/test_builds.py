"""Builds that do not come to their end: nothing of them stays, and nobody waits for them."""

import errno
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from planter.kernels import builds, toolchain
from planter.kernels.compiler import CompilerError
from tests.support.lanes import build_square, needs_compiler

ROOT = Path(__file__).parents[3]
SOURCE = "double twice(double x) { return 2.0 * x; }\n"
BUILDING = """
import threading, time, casadi as ca
from planter.kernels import Kernel
x = ca.SX.sym("x")
kernel = Kernel(ca.Function("square", [x], [x**2], ["x"], ["y"]), lanes=["x"])
threading.Thread(target=kernel.compile, daemon=True).start()
while not {begun!r} or not __import__("pathlib").Path({begun!r}).exists():
    time.sleep(0.01)
print(kernel(x=[3.0])["y"][0, 0], flush=True)
{then}
"""

pytestmark = [needs_compiler, pytest.mark.fault]


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("PLANTER_CACHE", str(tmp_path / "cache"))
    monkeypatch.setenv("TMPDIR", str(tmp_path / "temporary"))
    (tmp_path / "temporary").mkdir()
    monkeypatch.delenv("PLANTER_KERNELS", raising=False)
    return tmp_path / "cache"


def left(folder: Path) -> list[str]:
    return sorted(
        path.name for path in (*folder.iterdir(), *(folder.parent / "temporary").iterdir())
    )


def compiler_that(does: str, folder: Path) -> Path:
    """A compiler that answers like one, and does something else in place of a kernel."""
    path = folder / "slow-cc"
    path.write_text(f'#!/bin/sh\ncase "$*" in *kernel.c*) {does};; *) exec cc "$@";; esac\n')
    path.chmod(0o755)
    return path


def started(tmp_path: Path, then: str) -> subprocess.Popen[str]:
    """A process that has begun to build on a daemon thread."""
    begun = tmp_path / "begun"
    cc = compiler_that(f"echo half > \"${{TMPDIR}}/half.s\"; touch '{begun}'; sleep 100", tmp_path)
    program = BUILDING.format(begun=str(begun), then=then)
    return subprocess.Popen(
        [sys.executable, "-c", program],
        cwd=ROOT,
        env=os.environ | {"CC": str(cc)},
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )


@pytest.mark.parametrize(
    ("then", "code"), [("", 0), ("raise SystemExit(3)", 3), ("raise KeyboardInterrupt", -2)]
)
def test_finished_process_leaves_no_files_or_output(
    then: str, code: int, folder: Path, tmp_path: Path
) -> None:
    began = time.monotonic()
    process = started(tmp_path, then)
    output, wrong = process.communicate(timeout=60)
    assert time.monotonic() - began < 30
    assert output.strip() == "9.0"
    assert process.returncode == code
    assert "slower" not in wrong
    assert wrong == "" or code == -2
    assert left(folder) == []
    assert (
        subprocess.run(
            ["pgrep", "-f", str(tmp_path / "slow-cc")], capture_output=True, check=False
        ).stdout
        == b""
    )


@pytest.mark.skipif(
    not Path("/proc/self/stat").exists(), reason="elsewhere what is left goes by its age"
)
def test_next_build_removes_files_of_killed_process(folder: Path, tmp_path: Path) -> None:
    process = started(tmp_path, "time.sleep(100)")
    assert process.stdout is not None
    process.stdout.readline()
    (building,) = folder.iterdir()
    assert (building / "half.s").exists()
    path = toolchain.build_library("twice", SOURCE, ())
    assert left(folder) == sorted([building.name, path.name])
    process.send_signal(signal.SIGKILL)
    process.communicate()
    path.unlink()
    assert left(folder) == [building.name]
    toolchain.build_library("twice", SOURCE, ())
    assert left(folder) == [path.name]


@pytest.mark.parametrize(("age", "stays"), [(60, True), (2 * builds.ABANDONED_S, False)])
def test_files_of_other_systems_expire(age: float, stays: bool, folder: Path) -> None:
    """On a disk that several share, a number is no process of ours."""
    toolchain.cache_folder()
    other = folder / f"{builds.PREFIX}-0123456789ab-1-1-abc"
    other.mkdir()
    os.utime(other, (time.time() - age,) * 2)
    path = toolchain.build_library("twice", SOURCE, ())
    assert left(folder) == sorted([path.name, *([other.name] if stays else [])])


def test_a_folder_of_another_kind_stays(folder: Path) -> None:
    toolchain.cache_folder()
    (folder / f"{builds.PREFIX}-mine").mkdir()
    toolchain.build_library("twice", SOURCE, ())
    assert (folder / f"{builds.PREFIX}-mine").exists()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork")
def test_forked_child_does_not_disturb_parent_build(folder: Path, tmp_path: Path) -> None:
    then = "import os, sys\nif (child := os.fork()) == 0:\n    sys.exit()\nos.waitpid(child, 0)\n"
    then += "import pathlib\nprint(len(list(pathlib.Path(os.environ['PLANTER_CACHE']).iterdir())))"
    output, _ = started(tmp_path, then).communicate(timeout=60)
    assert output.split() == ["9.0", "1"]
    assert left(folder) == []


class TestFullDisk:
    def full(self, count: int) -> None:
        for number in range(count):
            with pytest.raises(CompilerError, match="there is no space for compiled functions in"):
                toolchain.build_library("twice", SOURCE + f"// {number}\n", ())

    def test_failing_compilers_are_not_retried(
        self, folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        calls = tmp_path / "calls"
        does = f"echo >> '{calls}'; echo 'as: kernel.o: No space left on device' >&2; exit 1"
        monkeypatch.setenv("CC", str(compiler_that(does, tmp_path)))
        self.full(3)
        assert len(calls.read_text().splitlines()) == 1
        assert left(folder) == []

    def test_full_disk_leaves_no_library(
        self, folder: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        def full(path: Path, content: bytes) -> int:
            path.touch()
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

        with monkeypatch.context() as patch:
            patch.setattr(Path, "write_bytes", full)
            self.full(1)
        assert left(folder) == []
        self.full(1)

    def test_kernels_work_with_a_single_warning(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
    ) -> None:
        monkeypatch.setattr(toolchain, "_warnings", [])
        monkeypatch.setenv(
            "CC", str(compiler_that("echo 'No space left on device' >&2; exit 1", tmp_path))
        )
        for power in (2, 3):
            kernel = build_square(power=power)
            kernel.compile()
            assert kernel(x=[3.0])["y"][0, 0] == 3**power
        assert [r.getMessage().partition("functions: ")[2] for r in caplog.records] == [
            f"there is no space for compiled functions in {tmp_path / 'cache'}"
        ]


def test_slow_compilation_is_given_up(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(toolchain, "TIMEOUT_S", 0.5)
    monkeypatch.setenv("CC", str(compiler_that("sleep 100; exit", tmp_path)))
    with pytest.raises(CompilerError, match=r"slow-cc did not compile twice within 0\.5 s"):
        toolchain.build_library("twice", SOURCE, ())
    assert left(folder) == []


def test_a_first_simulation_waits_for_no_compiler(folder: Path, tmp_path: Path) -> None:
    """It compiles nothing, and leaves nothing in the cache."""
    compiler = tmp_path / "cc"
    compiler.write_text(f"#!/bin/sh\ntouch '{tmp_path / 'called'}'\nsleep 100\n")
    compiler.chmod(0o755)
    command = [sys.executable, "-m", "planter", "simulate", "wang2017", "--json"]
    options = ["--out", str(tmp_path / "out")]
    environment = os.environ | {"CC": str(compiler)}
    done = subprocess.run(
        [*command, *options], cwd=ROOT, env=environment, capture_output=True, check=True
    )
    assert json.loads(done.stdout)["machine"]
    assert not (tmp_path / "called").exists()
    assert not folder.exists()
