"""Processes beside the first: no file of the user's is executed, and none outlives the one that
started it.
"""

import json
import os
import pickle
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from planter.task import Task
from planter.workers import Worker, WorkerEndedError
from tests.planter.toys import prepare_squares

pytestmark = pytest.mark.fault
ROOT = Path(__file__).parents[2]
JOBS = "planter.task"
PARENT = """
import pickle, sys, threading
sys.path.insert(0, {root!r})
from planter import workers
from planter.task import Task
from tests.planter.toys import prepare_squares
worker = workers.Worker({module!r}, Task(prepare_squares, {arguments!r}).to_bytes())
print(worker.pid, flush=True)
worker.ask(pickle.dumps(1))
"""


def _squares(**arguments: object) -> Task:
    return Task(prepare_squares, arguments)


def _wait_for(condition: Callable[[], bool], limit_s: float = 30.0) -> None:
    limit = time.monotonic() + limit_s
    while not condition() and time.monotonic() < limit:
        time.sleep(0.02)
    assert condition()


def _runs(pid: int) -> bool:
    try:
        return "Z" not in Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except FileNotFoundError:
        return False


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="processes are looked up in /proc")
def test_busy_worker_ends_with_parent(tmp_path: Path) -> None:
    task = _squares(mark=str(tmp_path / "at work"), wait_s=600.0)
    code = PARENT.format(root=str(ROOT), module=JOBS, arguments=task.arguments)
    parent = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert parent.stdout is not None
    pid = int(parent.stdout.readline())
    _wait_for((tmp_path / "at work").exists)
    assert _runs(pid)
    os.kill(parent.pid, signal.SIGKILL)
    parent.wait()
    _wait_for(lambda: not _runs(pid))


@pytest.mark.parametrize("module", [JOBS, "planter.studio.session"])
def test_worker_takes_no_module_of_the_user(
    module: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("json", "pickle", "queue", "numpy", "planter"):
        (tmp_path / f"{name}.py").write_text(f"open({str(tmp_path / 'executed')!r}, 'w').close()\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", ["", *sys.path])
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    is_jobs = module == JOBS
    folders = {"folder": str(tmp_path), "scratch": str(tmp_path), "machine": None}
    first = _squares().to_bytes() if is_jobs else json.dumps(folders).encode()
    request = pickle.dumps(3) if is_jobs else json.dumps({"do": "file", "message": {}}).encode()
    worker = Worker(module, first)
    try:
        answer = worker.ask(request)
    finally:
        worker.end()
    assert not (tmp_path / "executed").exists()
    assert pickle.loads(answer) == 3.0 if is_jobs else b"no machine is open" in answer


def test_late_or_verbose_worker_is_ended() -> None:
    late = Worker(JOBS, _squares(wait_s=600.0).to_bytes())
    with pytest.raises(TimeoutError):
        late.ask(pickle.dumps(1), limit_s=0.5)
    with pytest.raises(WorkerEndedError):
        late.ask(pickle.dumps(1))
    wordy = Worker(JOBS, _squares().to_bytes(), longest_answer=3)
    with pytest.raises(WorkerEndedError):
        wordy.ask(pickle.dumps(1))
