"""Lane kernels in tests: their C text compiled with flags of one's own, called with arrays."""

import shutil
import subprocess
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from planter.kernels import Array, Kernel, backends, toolchain
from planter.kernels.backends import LaneTask

NAMED = {
    "gcc": "gcc",
    "clang": next(
        (n for n in ("clang", *(f"clang-{v}" for v in range(22, 10, -1))) if shutil.which(n)),
        "clang",
    ),
}
"""Compilers by their name; the newest clang that there is."""
STRICT = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-O2")
needs_compiler = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")


def path_of(compiler: str) -> str:
    """The compiler's path; the test is skipped where it is absent."""
    path = shutil.which(NAMED[compiler])
    if path is None:
        pytest.skip(f"no {compiler}")
    return path


def compiled(text: str, target: Path, *flags: str, compiler: str = "gcc") -> Path:
    """An object file. Raises CalledProcessError with the compiler's words."""
    source = target.with_suffix(".c")
    source.write_text(text, encoding="utf-8")
    command = [path_of(compiler), *flags, "-fPIC", "-c", str(source), "-o", str(target)]
    subprocess.run(command, check=True, capture_output=True, text=True)
    return target


def for_processor(work: LaneTask, march: str, folder: Path) -> backends.LaneBackend:
    """A lane kernel compiled with the flags of the library, but for another processor."""
    folder.mkdir(exist_ok=True)
    flags = ("-std=gnu99", *work.passes, *toolchain.FAST_MATH, f"-march={march}")
    compiled(work.loop, folder / "kernel.o", *flags)
    library = folder / "kernel.so"
    subprocess.run(
        [path_of("gcc"), "-shared", str(folder / "kernel.o"), "-o", str(library), "-lm"], check=True
    )
    return backends.LaneBackend(work, library)


def work(
    names: str, outputs: dict[str, ca.SX], inputs: Sequence[ca.SX], lanes: str, summed: bool = False
) -> LaneTask:
    """The work of a function `f`; names of inputs and lanes stand in texts, parted by spaces."""
    function = ca.Function("f", list(inputs), list(outputs.values()), names.split(), list(outputs))
    return LaneTask(function, tuple(lanes.split()), summed)


def evaluated(work: LaneTask, way: backends.Backend, *arrays: object) -> dict[str, Array]:
    """Outputs by name of arrays (rows, lanes), or (rows, columns) for what is shared."""
    arguments = [np.atleast_2d(np.asarray(a, dtype=float)) for a in arrays]
    count = max(
        a.shape[1]
        for a, n in zip(arguments, work.function.name_in(), strict=True)
        if n in work.varying
    )
    return dict(zip(work.function.name_out(), way(arguments, count), strict=True))


def both(work: LaneTask, *arrays: object) -> tuple[dict[str, Array], dict[str, Array]]:
    """Outputs of the lane kernel, and of CasADi's virtual machine, which may be infinite without a
    complaint.
    """
    return evaluated(work, backends.build_compiled(work, "lanes"), *arrays), evaluated(
        work, backends.VirtualMachine(work), *arrays
    )


def difference(first: Array, other: Array) -> float:
    """The largest difference, measured by the largest value of the second."""
    assert first.shape == other.shape
    return float(np.abs(first - other).max() / np.abs(other).max())


def unsummed(work: LaneTask) -> LaneTask:
    return replace(work, summed=False)


def build_square(name: str = "square", power: int = 2) -> Kernel:
    """Return a kernel of a power over lanes."""
    x = ca.SX.sym("x")
    return Kernel(ca.Function(name, [x], [x**power], ["x"], ["y"]), lanes=["x"])


def shortest(call: Callable[[], object]) -> float:
    """Microseconds of a call, undisturbed."""
    times = []
    for _ in range(300):
        began = time.perf_counter()
        for _ in range(20):
            call()
        times.append((time.perf_counter() - began) / 20)
    return 1e6 * min(times)
