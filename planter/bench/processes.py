"""Works in a separate process: a cold start, and the derivation."""

from __future__ import annotations

import importlib.util
import shutil
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from planter import workers
from planter.bench.case import MACHINE, Absent
from planter.errors import ComputationError

GRADIENT = f"""\
from planter import Device, Turns, load_machine
turns = Turns(Device(load_machine({MACHINE!r})))
turns.gradient(turns.device.design)
"""
"""What a new process does: import, read the machine, compose its functions, objective and gradient of one turn."""
DERIVED = ("derive", "generated", "planter")
"""What the derivation reads and writes, in a checkout."""

Start = Callable[[object], None]


@contextmanager
def cold_starts() -> Iterator[tuple[dict[str, Start], dict[str, str]]]:
    """New processes by name, and what each does; the caches of compiled functions are filled before, but in one."""
    with tempfile.TemporaryDirectory(prefix="planter-") as folder:
        first = _folders(Path(folder))

        def gradient(way: str, cache: Callable[[], Path | None] = lambda: None) -> Start:
            return lambda _: _run(workers.python_command(GRADIENT), PLANTER_KERNELS=way, PLANTER_CACHE=cache())

        starts: dict[str, Start] = {
            "lanes": gradient("lanes"),
            "casadi-c": gradient("casadi-c"),
            "casadi-vm": gradient("casadi-vm"),
            "first run": gradient("lanes", lambda: next(first)),
            "simulate": lambda _: _run(workers.program_command("planter", "simulate", MACHINE, "--json")),
            "import": lambda _: _run(workers.python_command("import planter")),
            "python": lambda _: _run(workers.python_command("")),
        }
        turn = "new process to objective and gradient of a turn"
        built = {
            "lanes": f"{turn}, kernels in the cache", "casadi-c": f"{turn}, kernels in the cache",
            "casadi-vm": f"{turn}, nothing compiled", "first run": f"{turn}, lanes, empty cache: compiles them",
            "simulate": f"planter simulate {MACHINE} --json", "import": "import planter", "python": "nothing",
        }  # fmt: skip
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
        raise ComputationError(f"a process of Python ended with {done.returncode}: {' '.join(reason)}")


def root() -> Path:
    """The checkout that has `derive/`. Raises Absent if it is missing, or SymPy is."""
    for name in ("derive", "sympy"):
        if importlib.util.find_spec(name) is None:
            raise Absent(f"{name} cannot be imported here")
    place = importlib.util.find_spec("derive")
    folder = Path(str(place.origin if place else "")).parents[1]
    if not all((folder / name).is_dir() for name in DERIVED):
        raise Absent("this is not a checkout")
    return folder


def derive(example: str, folder: Path) -> None:
    """An example of the guide, derived into a folder. Raises Absent outside a checkout or without SymPy."""
    source = root() / "docs" / "examples" / f"{example}.py"
    if not source.is_file():
        raise Absent(f"there is no {source.name} here")
    _run(workers.program_command("derive", str(source), "--out", str(folder)))


@contextmanager
def derivation() -> Iterator[Start]:
    """`python -m derive` in a copy of the checkout, so that nothing is written there. Raises Absent."""
    source = root()
    with tempfile.TemporaryDirectory(prefix="planter-") as folder:
        copy = Path(folder)
        for name in DERIVED:
            shutil.copytree(source / name, copy / name)
        yield lambda _: _run(workers.program_command("derive", checkout=copy), cwd=copy)
