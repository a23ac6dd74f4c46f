"""The C text itself: one kernel kept as text, no warnings, vector instructions on every x86-64.

`python -m tests.planter.kernels.test_source` writes the kept text again, for a change that is
wanted.
"""

import platform
import re
import shutil
import subprocess
from collections import Counter
from importlib import resources
from itertools import product
from pathlib import Path

import casadi as ca
import pytest

from planter.kernels import toolchain
from planter.kernels.backends import LARGE_FUNCTION, LaneTask
from planter.kernels.lane_graph import LaneGraph
from planter.kernels.lane_source import print_file
from planter.papers.planting import file
from planter.papers.planting.functions import MODELS, Model
from planter.papers.planting.model import Device
from tests.support.lanes import STRICT, compiled, needs_compiler, work
from tests.support.sampled import sampled

GOLDEN = Path(__file__).with_name("golden") / "kernels.c"
phi, x = ca.SX.sym("phi"), ca.SX.sym("x", 2)
VECTORS = {"x86-64": ("b", "xmm"), "x86-64-v2": ("b", "xmm"), "x86-64-v3": ("d", "ymm")}
"""The letter of the vector library's calls, and the widest registers, by processor."""
on_x86_64 = pytest.mark.skipif(
    platform.machine() != "x86_64", reason="vector instructions of x86-64"
)
needs_disassembler = pytest.mark.skipif(shutil.which("objdump") is None, reason="no objdump")


def small() -> LaneTask:
    """What a kernel can hold: a shared value, an angle's functions, a branch, logic, a vector and a
    scalar output.
    """
    inside = ca.logic_and(phi > x[0], ca.logic_not(phi > 3.5))
    curve = ca.if_else(inside, ca.sin(phi) * ca.sqrt(x[1]), ca.cos(phi) - 0.5)
    return work(
        "phi x",
        {"curve": curve, "both": ca.vertcat(curve**2, x[0] * ca.floor(phi))},
        [phi, x],
        "phi",
    )


def text() -> str:
    graph = LaneGraph.from_function(small().function, ["phi"])
    function = small().function
    inputs = function.sx_in()
    total = ca.Function("total", inputs, function.call(inputs)[:1], ["phi", "x"], ["curve"])
    return print_file([graph, LaneGraph.from_function(total, ["phi"])], [False, True])


def test_a_kernel_as_text() -> None:
    assert text() == GOLDEN.read_text(encoding="utf-8"), (
        "wanted? python -m tests.planter.kernels.test_source"
    )


def _device_works(model: Model) -> list[LaneTask]:
    response = Device(file.load("wang2017"), model).force.response
    return [response.values_kernel.work, response.slopes_kernel.work]


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
@pytest.mark.parametrize("march", ["", "x86-64", "x86-64-v3"])
def test_no_compiler_warns(compiler: str, march: str, tmp_path: Path) -> None:
    """Clang among them, which vectorises no loop with an arc tangent: its list of vector functions
    has none.
    """
    if march and platform.machine() != "x86_64":
        pytest.skip("processors of x86-64")
    flags = (*STRICT, *([f"-march={march}"] if march else []), "-ffast-math")
    cycles = resources.files("planter.engine").joinpath("cycles.c").read_text(encoding="utf-8")
    for number, source in enumerate((text(), cycles, _device_works("exact")[0].loop)):
        compiled(source, tmp_path / f"{number}.o", *flags, compiler=compiler)


def test_a_warning_would_be_seen(tmp_path: Path) -> None:
    spoilt = text().replace("const double t1 = phi[i];", "const double t1 = phi[i]; double unused;")
    assert spoilt != text()
    with pytest.raises(subprocess.CalledProcessError) as caught:
        compiled(spoilt, tmp_path / "k.o", *STRICT)
    assert "unused" in caught.value.stderr


def _object(task: LaneTask, march: str, folder: Path) -> Path:
    wide = ["-mprefer-vector-width=512"] if march == "native" else []
    flags = ("-std=gnu99", *task.passes, *toolchain.FAST_MATH, f"-march={march}", *wide)
    return compiled(task.loop, folder / "kernel.o", *flags)


def count_selections(path: Path) -> set[str]:
    """Symbols that an object file takes from others."""
    lines = subprocess.run(
        ["nm", "-u", str(path)], check=True, capture_output=True, text=True
    ).stdout.splitlines()
    return {line.split()[-1] for line in lines}


def _arithmetic(path: Path) -> Counter[str]:
    """How often each kind of register is added, multiplied, divided whole (packed), and
    `scalar`.
    """
    command = ["objdump", "-d", "--no-show-raw-insn", str(path)]
    instructions: Counter[str] = Counter()
    for line in subprocess.run(
        command, check=True, capture_output=True, text=True
    ).stdout.splitlines():
        match = re.search(r"\tv?(?:add|sub|mul|div|fn?m(?:add|sub)\d+)(pd|sd)\s.*%(.mm)\d+", line)
        if match:
            instructions[match[2] if match[1] == "pd" else "scalar"] += 1
    return instructions


def _width(march: str) -> tuple[str, str]:
    if march != "native":
        return VECTORS[march]
    flags = Path("/proc/cpuinfo").read_text(encoding="utf-8")
    return (
        ("e", "zmm")
        if "avx512dq" in flags
        else VECTORS["x86-64-v3" if " fma " in flags else "x86-64"]
    )


@on_x86_64
@needs_disassembler
@pytest.mark.parametrize(
    ("march", "model"),
    sampled(
        [("x86-64", "exact"), ("x86-64-v3", "printed"), ("native", "exact")],
        product(["x86-64", "x86-64-v2", "x86-64-v3", "native"], MODELS),
    ),
)
def test_a_device_s_kernels_are_vector_instructions(
    march: str, model: Model, tmp_path: Path
) -> None:
    """Each operation stands there packed, once more one by one for lanes left over; what lanes
    share is scalar.
    """
    letter, register = _width(march)
    calls = {f"_ZGV{letter}N{ {'b': 2, 'd': 4, 'e': 8}[letter] }v_{f}" for f in ("sin", "cos")}
    for task in _device_works(model)[: 2 if march == "native" else 1]:
        path = _object(task, march, tmp_path)
        instructions, expected = _arithmetic(path), count_selections(path)
        assert (
            instructions[register]
            >= 0.9 * len(LaneGraph.from_function(task.function, task.varying).varying) / 2
        )
        assert instructions[register] >= 0.8 * instructions["scalar"]
        fused = letter != "b"
        assert not expected & {"sin", "cos"} if fused else calls <= expected
        assert "sincos" not in expected
        assert any(name.startswith(f"_ZGV{letter}") for name in expected)


@on_x86_64
@needs_disassembler
@pytest.mark.parametrize("march", ["x86-64", "native"])
def test_loop_with_scalar_call_is_detected(march: str, tmp_path: Path) -> None:
    force = ca.if_else(phi > x[0], ca.sin(phi) * ca.sqrt(x[1]), ca.cos(phi)) * phi
    good = work("phi x", {"y": force}, [phi, x], "phi")
    bad = work("phi x", {"y": force + ca.fmod(phi, x[1])}, [phi, x], "phi")
    _, register = _width(march)
    assert _arithmetic(_object(good, march, tmp_path))[register] > 0
    assert _arithmetic(_object(bad, march, tmp_path))[register] == 0


@on_x86_64
@needs_disassembler
def test_unseparated_sine_and_cosine_are_detected(tmp_path: Path) -> None:
    """A compiler merges them into one call, and the loop is no vector loop any more."""
    task = work("phi", {"y": ca.sin(phi) * ca.cos(phi) + phi}, [phi], "phi")
    assert _arithmetic(_object(task, "x86-64", tmp_path))["xmm"] > 0
    merged = task.loop.replace("x + f_zero", "x")
    assert merged != task.loop
    flags = ("-std=gnu99", *task.passes, *toolchain.FAST_MATH, "-march=x86-64")
    path = compiled(merged, tmp_path / "merged.o", *flags)
    assert _arithmetic(path)["xmm"] == 0
    assert count_selections(path) & {"sincos", "cexpi", "cexp"}


@needs_compiler
@pytest.mark.usefixtures("kernel_cache")
def test_large_functions_are_compiled_with_fewer_passes() -> None:
    response = Device(file.load("wang2017")).force.response
    assert response.slopes_kernel.work.passes == toolchain.OPTIMISED
    assert response.hessian_kernel.work.size > LARGE_FUNCTION
    assert response.hessian_kernel.work.passes == toolchain.FEW_PASSES


if __name__ == "__main__":
    GOLDEN.write_text(text(), encoding="utf-8")
