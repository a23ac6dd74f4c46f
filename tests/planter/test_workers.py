"""Processes beside the first: no file of the user's is executed, and none outlives the one that started it."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from planter import workers

pytestmark = pytest.mark.fault
ROOT = Path(__file__).parents[2]
MODULES = ("planter.optimise.second_process", "planter.planting.compare.worker")
PARENT = """
import subprocess, sys, time
sys.path.insert(0, {root!r})
from planter import workers
started = workers.start_worker({module!r}, subprocess.DEVNULL)
started.stdin.write({task!r} + "\\n")
started.stdin.flush()
print(started.pid, flush=True)
time.sleep(600)
"""


def _task(module: str) -> str:
    """Work for minutes."""
    if module.endswith("worker"):
        from planter.planting import file

        own = file.load("wang2017-wide")
        return json.dumps(
            {"machine": own.table(), "source": "x", "pair": ["ellipse", "ellipse"], "starts": 9, "seed": 0}
        )
    from planter.planting import problem
    from tests.planter.optimise import toys

    recipe = problem.recipe(toys.device(), 720)
    return json.dumps({"function": recipe.function, "arguments": recipe.arguments, "seed": 0, "starts": 5000})


def _runs(pid: int) -> bool:
    try:
        return "Z" not in Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except FileNotFoundError:
        return False


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="processes are looked up in /proc")
@pytest.mark.parametrize("module", MODULES)
def test_a_worker_ends_with_its_parent(module: str) -> None:
    code = PARENT.format(root=str(ROOT), module=module, task=_task(module))
    parent = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert parent.stdout is not None
    pid = int(parent.stdout.readline())
    time.sleep(3)
    assert _runs(pid)
    os.kill(parent.pid, signal.SIGKILL)
    parent.wait()
    limit = time.monotonic() + 30
    while _runs(pid) and time.monotonic() < limit:
        time.sleep(0.1)
    assert not _runs(pid)


@pytest.mark.parametrize("module", MODULES)
def test_a_module_of_the_user_s_is_not_taken_for_the_library_s(
    module: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("json", "queue", "numpy", "planter"):
        (tmp_path / f"{name}.py").write_text(f"open({str(tmp_path / 'executed')!r}, 'w').close()\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", ["", *sys.path])
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    asked = {"machine": {}, "source": "a file", "pair": None}
    line = json.dumps(asked if module.endswith("worker") else {"function": "none:none", "arguments": {}})
    worker = workers.start_worker(module, subprocess.PIPE)
    try:
        assert worker.stdin is not None
        assert worker.stdout is not None
        worker.stdin.write(line + "\n")
        worker.stdin.flush()
        said = worker.stdout.readline()
    finally:
        workers.end_worker(worker)
    assert not (tmp_path / "executed").exists()
    assert not module.endswith("worker") or "a file" in json.loads(said)["error"]["message"]
