"""Running compilers, each in a separate folder inside the cache.

A folder goes when its build ends, also if the process ends during it, on a daemon thread. It is
named by the system and the process that made it, so that the next build removes what a process that
was killed has left.
"""

from __future__ import annotations

import atexit
import hashlib
import os
import platform
import shutil
import signal
import subprocess
import tempfile
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from types import MappingProxyType

from planter import workers

PREFIX = "building"
ABANDONED_S = 3600
"""Age from which on a folder of another system is nobody's any more."""
TEMPORARY = ("TMPDIR", "TMP", "TEMP")
"""Variables that name the folder for temporary files, on one system or another."""
REMOVALS = 50
"""How often a folder is tried to be removed, over a second."""

Process = subprocess.Popen[bytes]


class _OpenBuilds:
    """The folders that are removed when the process ends."""

    processes: set[Process]
    folders: set[Path]

    def __init__(self) -> None:
        self.begin()

    def begin(self) -> None:
        """Also in a forked child: compilers and folders that are there are its parent's."""
        self.lock, self.ended = threading.Lock(), False
        self.processes, self.folders = set(), set()

    def end(self) -> None:
        with self.lock:
            self.ended = True
            for process in list(self.processes):
                _kill_group(process)
            for folder in list(self.folders):
                _remove_folder(folder)

    def go_on(self) -> None:
        """Ends the thread, which nobody waits for, once the process has ended."""
        if self.ended:
            raise SystemExit


_open = _OpenBuilds()
atexit.register(_open.end)
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_open.begin)


def run_program(
    command: Sequence[str],
    seconds: float,
    folder: Path | None = None,
    variables: Mapping[str, str] = MappingProxyType({}),
) -> subprocess.CompletedProcess[bytes]:
    """Return the output of a command, in English; `folder` holds its temporary files.

    `variables` are added to the environment of this process.

    Raises OSError, CalledProcessError, or TimeoutExpired; in all cases nothing of it goes on
    running.
    """
    environment = (
        os.environ | {"LC_ALL": "C"} | (dict.fromkeys(TEMPORARY, str(folder)) if folder else {})
    )
    with _open.lock:
        _open.go_on()
        process = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            env=environment | dict(variables),
            **workers.detached_process_options(),
        )
        _open.processes.add(process)
    with process:
        try:
            output, errors = process.communicate(timeout=seconds)
        except BaseException:
            _kill_group(process)
            raise
        finally:
            _open.processes.discard(process)
    if process.returncode:
        _open.go_on()
        raise subprocess.CalledProcessError(process.returncode, command, output, errors)
    return subprocess.CompletedProcess(command, process.returncode, output, errors)


def _kill_group(process: Process) -> None:
    """Kill a process together with its descendants."""
    try:
        if hasattr(os, "killpg"):
            os.killpg(process.pid, signal.SIGKILL)
        else:
            process.kill()
    except OSError:
        pass


@contextmanager
def scratch_folder(folder: Path) -> Iterator[Path]:
    """An empty folder inside another, for the time of a build.

    Raises OSError where there can be none.
    """
    _remove_abandoned(folder)
    with _open.lock:
        _open.go_on()
        # system, process and its start: numbers of processes are used again
        prefix = f"{PREFIX}-{_identify_system()}-{os.getpid()}-{_start_time(os.getpid())}-"
        scratch = Path(tempfile.mkdtemp(prefix=prefix, dir=folder))
        _open.folders.add(scratch)
    try:
        yield scratch
    except OSError:
        _open.go_on()
        raise
    finally:
        _remove_folder(scratch)
        _open.folders.discard(scratch)


def _remove_folder(folder: Path) -> None:
    """Also what a process that is being killed still writes there."""
    for _ in range(REMOVALS):
        shutil.rmtree(folder, ignore_errors=True)
        if not folder.exists():
            return
        time.sleep(0.02)


def _remove_abandoned(folder: Path) -> None:
    """Remove what dead processes have left."""
    for path in folder.glob(f"{PREFIX}-*"):
        if _is_abandoned(path):
            shutil.rmtree(path, ignore_errors=True)


def _is_abandoned(path: Path) -> bool:
    try:
        _, system, process, birth, _ = path.name.split("-", 4)
        if system == _identify_system():
            return _start_time(int(process)) != birth
        return time.time() - path.stat().st_mtime > ABANDONED_S
    except (OSError, ValueError):
        return False


@cache
def _identify_system() -> str:
    """Return a name of the system, its start time and its container, since each numbers processes
    separately.

    If they are unknown, every process counts as a separate system.
    """
    try:
        boot = Path("/proc/sys/kernel/random/boot_id").read_text(encoding="ascii")
        identity = boot + os.readlink("/proc/self/ns/pid")
    except OSError:
        identity = f"{platform.node()} {os.getpid()} {time.time()}"
    return hashlib.sha256(identity.encode()).hexdigest()[:12]


def _start_time(process: int) -> str:
    """When a process was started, in the system's ticks; empty for one that is not there, or not
    any more.
    """
    try:
        state, *fields = Path(f"/proc/{process}/stat").read_bytes().rpartition(b")")[2].split()
    except (OSError, ValueError):
        return ""
    return "" if state in (b"Z", b"X") else fields[18].decode()
