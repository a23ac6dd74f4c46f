"""A device's turn as CUDA: compiled where its compiler is, run where a graphics processor is, and its text run on
ordinary threads everywhere, which shows the numbers but neither the compiler nor the speed.
"""

import shutil
import subprocess
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from planter.errors import ComputationError
from planter.exports import cuda
from planter.kernels import Array, CallError
from planter.kernels.compiler import CompilerError
from planter.planting.cycle import sample_angles
from planter.planting.file import load
from planter.planting.functions import Model
from planter.planting.machines import build_machine
from planter.planting.model import Device
from planter.planting.objective import read_weights
from tests.support import machines, swapped
from tests.support.cli import run
from tests.support.cuda_on_threads import build_on_threads, needs_threads

EQUAL = 1e-11
needs_nvcc = pytest.mark.skipif(shutil.which("nvcc") is None, reason="no CUDA compiler: nvcc")


@cache
def device(name: str, model: Model = "exact") -> Device:
    return Device(swapped.machine() if name == "swapped" else load(name), model)


def draw_designs(device: Device, count: int) -> Array:
    rng = np.random.default_rng(11)
    return np.array([device.design, *(machines.design_near(device, rng) for _ in range(count - 1))])


def expected(device: Device, designs: Array, samples: int) -> Array:
    """By the virtual machine and NumPy, over the whole turn."""
    rows = []
    for x in designs:
        force = device.support(device.prologue(x), sample_angles(samples))
        span, variance = float(np.ptp(force)), float(force.var())
        objective = read_weights(device.machine).value(span, variance)
        rows.append((objective, span, variance, float(force.mean())))
    return np.array(rows)


def on_threads(device: Device, folder: Path, *changes: tuple[str, str]) -> Path:
    return build_on_threads(build_machine(device), folder, *changes)


@needs_threads
@pytest.mark.parametrize(
    ("name", "model", "samples"), [("wang2017", "exact", 360), ("compact", "printed", 37), ("swapped", "exact", 90)]
)
def test_cuda_text_equals_virtual_machine(name: str, model: Model, samples: int, tmp_path: Path) -> None:
    planting_device = device(name, model)
    batches, designs = (
        cuda.Batches(build_machine(planting_device), on_threads(planting_device, tmp_path), samples),
        draw_designs(planting_device, 5),
    )
    values, reference = batches(designs), expected(planting_device, designs, samples)
    assert (np.abs(values - reference) <= EQUAL * np.abs(reference)).all()


@needs_threads
def test_designs_in_chunks_and_a_tampered_text(tmp_path: Path) -> None:
    planting_device, samples = device("wang2017"), 24
    designs = draw_designs(planting_device, 5)
    reference = expected(planting_device, designs, samples)
    chunked = cuda.Batches(
        build_machine(planting_device), on_threads(planting_device, tmp_path, ("CHUNK = 65536", "CHUNK = 2")), samples
    )
    assert (np.abs(chunked(designs) - reference) <= EQUAL * np.abs(reference)).all()
    (tmp_path / "wrong").mkdir()
    changes = ("apart * apart * (a.count * b.count / count)", "0.0")
    wrong = cuda.Batches(
        build_machine(planting_device), on_threads(planting_device, tmp_path / "wrong", changes), samples
    )(designs)
    assert (np.abs(wrong - reference)[:, 2] > EQUAL * reference[:, 2]).all()
    assert (np.abs(wrong - reference)[:, 1] <= EQUAL * reference[:, 1]).all()
    for bad in (designs[0], designs[:, :9]):
        with pytest.raises(CallError, match=r"shape \(m, 10\)"):
            chunked(bad)
    designs[3, planting_device.names.index("e3_mm")] = 2 * designs[3, planting_device.names.index("R3_mm")]
    with pytest.raises(ComputationError, match="in row 3"):
        chunked(designs)


@needs_nvcc
def test_nvidia_s_compiler_takes_it(tmp_path: Path) -> None:
    library = cuda.build_library(build_machine(device("wang2017")), tmp_path, "compute_90")
    assert library.stat().st_size > 10_000
    (tmp_path / "wrong").mkdir()
    source = tmp_path / "wrong" / "w.cu"
    source.write_text((tmp_path / "wang2017.cu").read_text().replace("__syncthreads();", "__syncthreats();"))
    assert subprocess.run(["nvcc", "-c", str(source), "-o", "/dev/null"], capture_output=True, check=False).returncode


@needs_nvcc
@pytest.mark.long
def test_on_a_graphics_processor(tmp_path: Path) -> None:
    planting_device = device("wang2017")
    answer = (
        subprocess.run(["nvidia-smi", "-L"], capture_output=True, check=False) if shutil.which("nvidia-smi") else None
    )
    present = answer is not None and answer.returncode == 0
    library = cuda.build_library(build_machine(planting_device), tmp_path, "native" if present else "compute_90")
    if not present:
        with pytest.raises(CompilerError, match="no graphics processor"):
            cuda.Batches(build_machine(planting_device), library)
        pytest.skip("the CUDA kernels have not been run: there is no graphics processor here")
    designs = draw_designs(planting_device, 200)
    values, reference = (
        cuda.Batches(build_machine(planting_device), library)(designs),
        expected(planting_device, designs, 360),
    )
    assert (np.abs(values - reference) <= EQUAL * np.abs(reference)).all()


def test_missing_compiler_is_reported(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("PATH", "")
    with pytest.raises(CompilerError, match="there is no CUDA compiler"):
        cuda.build_library(build_machine(device("wang2017")), tmp_path)


def test_the_command_writes_it(tmp_path: Path) -> None:
    code, out, _ = run("export", "cuda", "compact", "--model", "printed", "--out", str(tmp_path))
    assert code == 0
    assert out.split() == [str(tmp_path / "compact_printed.cu")]
    assert (tmp_path / "compact_printed.cu").read_text().startswith("/* compact: ")
