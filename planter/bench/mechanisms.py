"""User-defined mechanisms, from their statements: the torque of the motor over a turn, squared, and
its gradient.

The statement is an example of the guide, derived for the benchmark. Every way starts from the
solved loops.
"""

from __future__ import annotations

import importlib
import importlib.util
import shutil
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import cached_property
from pathlib import Path
from types import ModuleType
from typing import Any

import casadi as ca
import numpy as np

from planter import workers
from planter.bench.case import EXACT, MACHINE, Absent, Contender, LeanFunction, compile_to_c
from planter.engine.response import MachineResponse
from planter.errors import ComputationError
from planter.kernels import Array, Kernel, generated, toolchain
from planter.kernels.compiler import CompilerError
from planter.mechanism.file import load
from planter.mechanism.machines import build_machine

EXAMPLES = {"slider-crank": "slider_crank", "four-bar": "transplanting_arm"}
"""Examples of the guide by task."""
ANGLES = 360
TORQUE = "M_in"
AROUND = 1e-3
"""Designs are drawn so far about the example's own values, in parts of these."""
STEP, DIFFERENCES = 1e-7, 1e-5
"""Step of forward differences, and how well the derivatives must agree."""
OWN = ("phi", "loops")


class MechanismCase:
    """A mechanism with values drawn about its own: designs (p,) in SI, angles (n,), coordinates of
    its loops (k, n).
    """

    def __init__(self, work: str, folder: Path) -> None:
        name = EXAMPLES[work]
        derive_example(name, folder)
        file = load(folder / f"{name}.toml")
        machine = build_machine(file)
        self.name, self.folder, self.formulas, self.data = name, folder, file.model, file.data()
        self.angles = 2 * np.pi * np.arange(ANGLES) / ANGLES
        self.places = np.ascontiguousarray(
            MachineResponse(machine).coordinates(machine.data, self.angles)
        )
        self.row = self.formulas.outputs("lane").index(TORQUE)
        self.hoists = "prologue" in self.formulas.sidecar["functions"]

    def designs(self, seed: int = 0) -> Iterator[Array]:
        """Yield random designs without end; the same seed yields the same ones."""
        rng = np.random.default_rng(seed)
        while True:
            yield self.data * (1 + AROUND * rng.uniform(-1, 1, len(self.data)))

    @cached_property
    def function(self) -> ca.Function:
        """(phi, loops, data) -> an angle's share of the mean square, and its gradient in the
        data.
        """
        phi, data = ca.SX.sym("phi"), ca.SX.sym("data", len(self.data))
        loops = ca.SX.sym("loops", len(self.places))
        inputs = [phi, data, *([loops] if len(self.places) else [])]
        hoisted = [self.formulas.function("prologue")(data)] if self.hoists else []
        share = self.formulas.function("lane")(*inputs, *hoisted)[self.row] ** 2 / ANGLES
        outputs = ca.cse([share, ca.densify(ca.gradient(share, data))])
        return ca.Function(
            self.name, [phi, loops, data], outputs, [*OWN, "data"], ["value", "gradient"]
        )

    @cached_property
    def turn(self) -> ca.Function:
        """Function of all angles, as a loop in CasADi."""
        return self.function.map(f"{self.name}_turn", "serial", ANGLES, [2], [0, 1])

    def mean(
        self, lane: Callable[..., Any], xp: Any, data: Any, prologue: Callable[..., Any]
    ) -> Any:
        """Return the mean square of the torque, computed by array code."""
        inputs = [self.angles, data, *([self.places] if len(self.places) else [])]
        torque = lane(xp, *inputs, *([prologue(xp, data)] if self.hoists else []))[self.row]
        return (torque**2).mean()

    @property
    def array(self) -> ModuleType:
        return generated.module(f"array/{self.name}", self.folder)


def build_kernel_contender(case: MechanismCase) -> Contender:
    """Return the kernel of planter, bound to its arrays.

    Raises Absent if kernels are evaluated otherwise here.
    """
    kernel = Kernel(case.function, lanes=OWN, summed=True)
    kernel.compile()
    if kernel.way != "lanes":
        raise Absent(f"here kernels are evaluated by {kernel.way}")
    data = case.data.copy()
    bound = kernel.bind(phi=case.angles, loops=case.places, data=data)

    def call(x: Array) -> tuple[float, Array]:
        data[:] = x
        outputs = bound()
        return float(outputs["value"][0, 0]), outputs["gradient"][:, 0].copy()

    return Contender(
        call, f"kernel bound to its arrays; {' '.join(toolchain.loop_flags(toolchain.OPTIMISED))}"
    )


def build_virtual_machine(case: MechanismCase) -> Contender:
    """Return the virtual machine of CasADi."""
    return _casadi(case, case.turn, "one function, angles in a loop, own memory")


def build_c_contender(case: MechanismCase) -> Contender:
    """Return the C code of CasADi. Raises Absent if it cannot be compiled."""
    try:
        return _casadi(
            case,
            compile_to_c(case.turn),
            f"the same in CasADi's C; {' '.join(toolchain.OPTIMISED)}",
        )
    except CompilerError as reason:
        raise Absent(str(reason)) from None


def _casadi(case: MechanismCase, function: ca.Function, built: str) -> Contender:
    run = LeanFunction(function)

    def call(x: Array) -> tuple[float, Array]:
        value, gradient = run(case.angles, case.places, x)
        return float(value[0, 0]), gradient[:, 0]

    return Contender(call, built)


def build_numpy_contender(case: MechanismCase) -> Contender:
    """Return array code in NumPy with forward differences."""
    module = case.array

    def value(x: Array) -> float:
        return float(case.mean(module.lane, np, x, getattr(module, "prologue", _nothing)))

    return _differences(value, "generated array code over all angles")


def build_jax_contender(case: MechanismCase) -> Contender:
    """Return array code in JAX. Raises Absent if it is not installed."""
    try:
        library = importlib.import_module("jax")
    except ModuleNotFoundError:
        raise Absent("jax is not installed") from None
    library.config.update("jax_enable_x64", True)
    module = case.array
    both = library.jit(
        library.value_and_grad(
            lambda x: case.mean(
                module.lane, library.numpy, x, getattr(module, "prologue", _nothing)
            )
        )
    )

    def call(x: Array) -> tuple[float, Array]:
        value, gradient = both(x)
        return float(value), np.asarray(gradient)

    return Contender(call, "jit of value_and_grad, float64, over all angles")


def build_sympy_contender(case: MechanismCase) -> Contender:
    """Raise Absent, since SymPy cannot do this task."""
    raise Absent("eliminations with pivots, written out, outgrow the expressions of SymPy")


def _nothing(*_: object) -> None:
    """Return no invariants, for a mechanism without a prologue."""


def _differences(value: Callable[[Array], float], built: str) -> Contender:
    def call(x: Array) -> tuple[float, Array]:
        centre, steps = value(x), STEP * np.maximum(np.abs(x), STEP)
        return centre, (np.array([value(x + step) for step in np.diag(steps)]) - centre) / steps

    return Contender(call, f"{built}; forward differences", (EXACT, DIFFERENCES))


BUILDERS: dict[str, Callable[[MechanismCase], Contender]] = {
    "casadi-vm": build_virtual_machine,
    "numpy": build_numpy_contender,
    "lambdify": build_sympy_contender,
    "jax": build_jax_contender,
    "casadi-c": build_c_contender,
    "lanes": build_kernel_contender,
}
"""Ways by their names; the first is what the others must agree with."""


GRADIENT = f"""\
from planter import Device, Turns, load_machine
turns = Turns(Device(load_machine({MACHINE!r})))
turns.gradient(turns.device.design)
"""
"""What a new process does: import, read the machine, compose its functions, objective and gradient
of one turn.
"""
DERIVED = ("derive", "generated", "planter")
"""What the derivation reads and writes, in a checkout."""

Start = Callable[[object], None]


@contextmanager
def cold_starts() -> Iterator[tuple[dict[str, Start], dict[str, str]]]:
    """Yield new processes by name, and descriptions; all caches of compiled functions but one are
    filled before.
    """
    with tempfile.TemporaryDirectory(prefix="planter-") as folder:
        first = _folders(Path(folder))

        def gradient(way: str, cache: Callable[[], Path | None] = lambda: None) -> Start:
            return lambda _: _run(
                workers.python_command(GRADIENT), PLANTER_KERNELS=way, PLANTER_CACHE=cache()
            )

        starts: dict[str, Start] = {
            "lanes": gradient("lanes"),
            "casadi-c": gradient("casadi-c"),
            "casadi-vm": gradient("casadi-vm"),
            "first run": gradient("lanes", lambda: next(first)),
            "simulate": lambda _: _run(
                workers.program_command("planter", "simulate", MACHINE, "--json")
            ),
            "import": lambda _: _run(workers.python_command("import planter")),
            "python": lambda _: _run(workers.python_command("")),
        }
        turn = "new process to objective and gradient of a turn"
        built = {
            "lanes": f"{turn}, kernels in the cache",
            "casadi-c": f"{turn}, kernels in the cache",
            "casadi-vm": f"{turn}, nothing compiled",
            "first run": f"{turn}, lanes, empty cache: compiles them",
            "simulate": f"planter simulate {MACHINE} --json",
            "import": "import planter",
            "python": "nothing",
        }
        for way in ("lanes", "casadi-c"):
            starts[way](None)
        yield starts, built


def _folders(folder: Path) -> Iterator[Path]:
    """New empty folders without end."""
    while True:
        yield Path(tempfile.mkdtemp(dir=folder))


def _run(command: Sequence[str], cwd: Path | None = None, **variables: object) -> None:
    environment = {name: str(value) for name, value in variables.items() if value is not None}
    done = workers.run_command(command, cwd, environment)
    if done.returncode:
        reason = done.stderr.strip().splitlines()[-1:]
        raise ComputationError(
            f"a process of Python ended with {done.returncode}: {' '.join(reason)}"
        )


def find_checkout() -> Path:
    """Return the checkout that contains `derive/`. Raises Absent if it is missing, or SymPy is."""
    for name in ("derive", "sympy"):
        if importlib.util.find_spec(name) is None:
            raise Absent(f"{name} cannot be imported here")
    place = importlib.util.find_spec("derive")
    folder = Path(str(place.origin if place else "")).parents[1]
    if not all((folder / name).is_dir() for name in DERIVED):
        raise Absent("this is not a checkout")
    return folder


def derive_example(example: str, folder: Path) -> None:
    """Derive an example of the guide into a folder.

    Raises Absent outside a checkout or without SymPy.
    """
    source = find_checkout() / "docs" / "examples" / f"{example}.py"
    if not source.is_file():
        raise Absent(f"there is no {source.name} here")
    _run(workers.program_command("derive", str(source), "--out", str(folder)))


@contextmanager
def prepare_derivation() -> Iterator[Start]:
    """Yield `python -m derive` in a copy of the checkout, which stays unchanged.

    Raises Absent if it is missing.
    """
    source = find_checkout()
    with tempfile.TemporaryDirectory(prefix="planter-") as folder:
        copy = Path(folder)
        for name in DERIVED:
            shutil.copytree(source / name, copy / name)
        yield lambda _: _run(workers.program_command("derive", checkout=copy), cwd=copy)
