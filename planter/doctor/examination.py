"""`planter doctor`: what this installation has, how functions are evaluated here, what would make that faster."""

from __future__ import annotations

import os
import platform
import threading
from collections.abc import Collection, Iterator
from importlib import metadata
from pathlib import Path

import numpy as np

from planter.doctor import installation
from planter.doctor.advice import advice
from planter.doctor.extras import list_extras
from planter.doctor.results import Advice, CompilerFound, Examination, KernelFound, Processor, Versions
from planter.kernels import Kernel, backends
from planter.planting import file
from planter.planting.functions import MODELS
from planter.planting.model import Device
from planter.version import __version__

MACHINE = "wang2017"


def examine(build: bool = False) -> Examination:
    """Return versions, compiler, cache, the way of each function of the built-in machine, and advice.

    Compiles only with `build`.
    """
    devices = {model: Device(file.load(MACHINE), model) for model in MODELS}
    if build:
        for device in devices.values():
            _build(device)
    compiler, (cache, refused) = installation.compiler(), installation.cache()
    usable, filled = isinstance(compiler, CompilerFound) and cache.problem is None, cache.files > 0
    kernels = [row for model, device in devices.items() for row in _kernels(model, device, usable, filled, refused)]
    return Examination(
        versions=Versions(
            planter=__version__, python=platform.python_version(), casadi=metadata.version("casadi"),
            numpy=np.__version__, c_library=" ".join(platform.libc_ver()).strip() or None,
        ),
        processor=Processor(platform.machine(), os.cpu_count()),
        compiler=compiler, cache=cache, machine=MACHINE, kernels=kernels, cuda=installation.cuda(),
        extras=list_extras(),
        advice=[*(Advice(reason, "remove it") for reason in refused.values()),
                *advice(MACHINE, compiler, cache, kernels)],
    )  # fmt: skip


def _build(device: Device) -> None:
    """Compile what an optimiser and a whole turn need, and wait for it."""
    from planter.planting.turns import Turns

    Turns(device)
    for refined in (False, True):
        device.compile(refined)
    for kernel in _used(device):
        kernel.compile()
    for thread in threading.enumerate():
        if thread.name.startswith("compile "):
            thread.join()


def _used(device: Device) -> tuple[Kernel, ...]:
    force = device.force.response
    return (force.hoisting_kernel, force.prologue_kernel, force.prologue_hessian_kernel, force.values_kernel,
            force.slopes_kernel, force.derivatives_kernel, force.rates_kernel, force.hessian_kernel)  # fmt: skip


def _kernels(
    model: str, device: Device, usable: bool, filled: bool, refused: Collection[Path]
) -> Iterator[KernelFound]:
    for kernel in _used(device):
        work = kernel.work
        way = backends.foreseen(work) if usable else backends.NAMES[-1]
        if refused and way != backends.NAMES[-1] and backends.place(work, way) in refused:
            way = backends.NAMES[-1]
        compiled = filled and way != backends.NAMES[-1] and backends.kept(work)
        yield KernelFound(model, str(work.function.name()), work.size, way, compiled)
