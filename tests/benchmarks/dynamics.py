"""`python -m tests.benchmarks.dynamics` measures the dynamics of machines that move freely.

It writes `dynamics.json` beside this file and the table of `docs/performance.md` between its marks;
`--page` writes the page of the record that there is. C is timed in C, Python in Python, all in CPU
time of one run.
"""

from __future__ import annotations

import argparse
import ctypes
import json
import platform
import re
import resource
import shutil
import subprocess
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

import casadi as ca
import numpy as np

from derive.__main__ import main as derive
from planter.exports import dynamics as exports
from planter.kernels import Array
from planter.mechanism.state_space.model import ARGUMENTS, DynamicsModel, load_dynamics
from tests.benchmarks import machines, peers
from tests.derive.test_robots import write_chain
from tests.planter.mechanism.state_space.statements import build_chain
from tests.support import own
from tests.support.cli import answer
from tests.support.structure import ROOT

RECORD, PAGE = Path(__file__).with_suffix(".json"), ROOT / "docs" / "performance.md"
BEGIN, END = "<!-- dynamics -->", "<!-- end of dynamics -->"
CHAINS, KANE = (3, 6, 12, 24, 50), (3, 6)
MOST_OPERATIONS = 30_000
"""Operations of a function that is compiled with FLAGS: more take a compiler minutes."""
MOST_GRAPH = 60
"""States of a model whose derivatives are built: more take minutes, too."""
FLAGS = ("-O3", "-march=native")
STATES = 10
"""States in which errors are measured."""
Record = dict[str, Any]


@dataclass(frozen=True)
class Machine:
    """A machine of the table: its name, a function that derives it and returns its file, and its
    tree in Pinocchio if it has one.
    """

    name: str
    derive: Callable[[], Path]
    tree: Callable[[], peers.Pinocchio] | None = None


def list_machines() -> list[Machine]:
    """Return the machines of the table."""
    robot = write_chain("parallel axes")
    chains = [build_chain_machine(links) for links in CHAINS]
    return [
        *chains,
        Machine("six-axis arm", lambda: _derive_robot(robot), lambda: peers.Pinocchio(robot=robot)),
        Machine("bicycle (Whipple)", lambda: _derive_example("whipple")),
        Machine("Andrews' mechanism", lambda: _derive_example("andrews")),
        Machine("four-bar, free", lambda: _derive_text(machines.FOUR_BAR)),
        Machine("Stewart platform", lambda: _derive_text(machines.build_platform())),
        Machine("wang2017, released", lambda: _derive_text(machines.build_released_device())),
    ]


def build_chain_machine(links: int) -> Machine:
    """Return a planar chain of rods."""
    return Machine(
        f"chain of {links}",
        lambda: _derive_text(build_chain(links)),
        lambda: peers.Pinocchio(links),
    )


def _derive_text(text: str, name: str = "own") -> Path:
    folder = Path(mkdtemp())
    statement = folder / f"{name}.py"
    statement.write_text(text, encoding="utf-8")
    for curve in own.EXAMPLES.glob("*.csv"):
        shutil.copy(curve, folder)
    assert derive([str(statement)]) == 0
    (file,) = (folder / "generated").glob("*.toml")
    return file


def _derive_example(name: str) -> Path:
    return _derive_text((own.EXAMPLES / f"{name}.py").read_text("utf-8"), name)


def _derive_robot(robot: Path) -> Path:
    folder = Path(mkdtemp())
    answer("derive", str(robot), "--out", str(folder))
    (file,) = folder.glob("*.toml")
    return file


# --- C -------------------------------------------------------------------------------------------

_TIMER = """
#include <time.h>
static double now(void) {
  struct timespec at;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &at);
  return at.tv_sec * 1e9 + at.tv_nsec;
}
void call(const double **arg, double **res) { NAME_graph(arg, res); }
double measure(long count, const double **arg, double **res) {
  double best = 1e300;
  for (int part = 0; part < 5; ++part) {
    double began = now(), taken;
    for (long k = 0; k < count; ++k) NAME_graph(arg, res);
    taken = (now() - began) / count;
    if (taken < best) best = taken;
  }
  return best;
}
"""


class CompiledGraph:
    """A dense function of a model as `planter export c` prints it, compiled: `compile_s` [CPU s] and
    `size_kb` of its text.
    """

    def __init__(self, function: ca.Function) -> None:
        self.function, folder = function, Path(mkdtemp())
        helpers, graph = exports._print_graphs({function.name(): function})
        head = "#include <math.h>\ntypedef double real;\n"
        text = head + helpers + graph + _TIMER.replace("NAME", function.name())
        source, target = folder / "graph.c", folder / "graph.so"
        source.write_text(text, encoding="utf-8")
        before = _children_time()
        command = ["cc", "-w", *FLAGS, "-fPIC", "-shared", str(source), "-lm", "-o", str(target)]
        subprocess.run(command, check=True, capture_output=True)
        self.compile_s = _children_time() - before
        self.size_kb = len(text) / 1000
        self._library = ctypes.CDLL(str(target))
        self._library.measure.restype = ctypes.c_double

    def evaluate(self, *vectors: Array | float) -> list[Array]:
        """Return the outputs, each in one row."""
        inputs, outputs = self._prepare(vectors)
        self._library.call(_point(inputs), _point(outputs))
        return outputs

    def measure(self, *vectors: Array | float) -> float:
        """Return the time [ns] of a call."""
        inputs, outputs = self._prepare(vectors)
        count = max(20, 20_000_000 // self.function.n_instructions())
        time_ns: float = self._library.measure(
            ctypes.c_long(count), _point(inputs), _point(outputs)
        )
        return time_ns

    def _prepare(self, vectors: tuple[Array | float, ...]) -> tuple[list[Array], list[Array]]:
        sizes = map(self.function.numel_out, range(self.function.n_out()))
        inputs = [np.array(vector, dtype=float, ndmin=1) for vector in vectors]
        return inputs, [np.zeros(max(size, 1)) for size in sizes]


def _point(arrays: list[Array]) -> Any:
    return (ctypes.c_void_p * len(arrays))(*(array.ctypes.data for array in arrays))


def _children_time() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


# --- planter -------------------------------------------------------------------------------------


def draw_states(model: DynamicsModel, has_tree: bool) -> list[Array]:
    """Return states that the constraints allow, of a tree anywhere, else near the start."""
    rng, start = np.random.default_rng(1), model.start
    if has_tree:
        return [rng.uniform(-1, 1, len(start)) for _ in range(STATES)]
    moved = (start + 0.02 * rng.standard_normal(len(start)) for _ in range(STATES))
    return [model.dynamics.project(0.0, state) for state in moved]


def measure_planter(machine: Machine) -> Record:
    """Return the row of a machine: times, sizes, operations and errors."""
    began = time.process_time()
    file = machine.derive()
    derive_s = time.process_time() - began
    model, tree = load_dynamics(file), machine.tree and _find_tree(machine)
    states = draw_states(model, tree is not None)
    arguments = 0.0, states[0], model.u, model.p
    row: Record = {
        "machine": machine.name,
        "coordinates": model.equations.size,
        "constraints": len(model.constraints),
        "derive_s": derive_s,
        "module_kb": file.with_suffix(".py").stat().st_size / 1000,
        "f_operations": model.f.n_instructions(),
        "f_python_ns": peers.time_call(lambda: model.rates(0.0, states[0])),
        "f_graph_ns": peers.time_call(_bind(model.f, arguments)),
    }
    compiled = CompiledGraph(exports._densify(model, "rates"))
    row |= {"f_ns": compiled.measure(*arguments), "compile_s": compiled.compile_s}
    reference = tree.accelerate if tree else _solve_densely(model)
    size, errors = model.equations.size, []
    for state in states:
        expected = reference(state[:size], state[size:], model.u)
        rates = compiled.evaluate(0.0, state, model.u, model.p)[0]
        errors.append(peers.find_error(rates[size:], expected))
    row |= {"error": max(errors), "reference": "Pinocchio" if tree else "NumPy"}
    return row | _measure_jacobian(model, tree, states)


def _find_tree(machine: Machine) -> peers.Pinocchio | None:
    return machine.tree() if machine.tree and peers.is_installed("pin") else None


def _bind(function: ca.Function, arguments: tuple[Array | float, ...]) -> Callable[[], object]:
    """Return CasADi's bare call of a function on memory that stays."""
    buffer, run = function.buffer()
    memory = [np.array(part, dtype=float, ndmin=1) for part in arguments]
    outputs = [np.zeros(function.nnz_out(i)) for i in range(function.n_out())]
    for i, array in enumerate(memory):
        buffer.set_arg(i, array.data)
    for i, array in enumerate(outputs):
        buffer.set_res(i, array.data)
    return lambda memory=(buffer, memory, outputs): run()


def _solve_densely(model: DynamicsModel) -> Callable[..., Array]:
    """Return accelerations by NumPy's solution of the dense equations with constraints."""

    def accelerate(q: Array, rates: Array, _: Array) -> Array:
        dynamics, state = model.dynamics, np.concatenate([q, rates])
        sizes = dynamics.find_sizes(0.0, state)
        return dynamics._accelerate(0.0, state, sizes, 1e-9)[0]

    return accelerate


def _measure_jacobian(
    model: DynamicsModel, tree: peers.Pinocchio | None, states: list[Array]
) -> Record:
    """Return what A, B and A, B, F take; nothing where they are too large."""
    if 2 * model.equations.size > MOST_GRAPH:
        return {}
    began, arguments = time.process_time(), (0.0, states[0], model.u, model.p)
    result: Record = {"jacobian_all_operations": model.f_jacobian.n_instructions()}
    result["jacobian_build_s"] = time.process_time() - began
    result["jacobian_python_ns"] = peers.time_call(lambda: model.linearised(0.0, states[0]))
    result["jacobian_graph_ns"] = peers.time_call(_bind(model.f_jacobian, arguments))
    symbols = model.f_jacobian.sx_in()
    graphs = [ca.densify(graph).T for graph in model.f_jacobian.call(symbols)]
    for key, parts in (("jacobian", graphs[:2]), ("jacobian_all", graphs)):
        function = ca.Function(key, symbols, ca.cse(parts), ARGUMENTS, list("ABF")[: len(parts)])
        result[f"{key}_operations"] = function.n_instructions()
        if function.n_instructions() <= MOST_OPERATIONS:
            compiled = CompiledGraph(function)
            result[f"{key}_ns"] = compiled.measure(*arguments)
            result[f"{key}_compile_s"] = compiled.compile_s
    if tree:
        size, errors = model.equations.size, []
        for state in states:
            expected = tree.differentiate(state[:size], state[size:], model.u)
            errors.append(peers.find_error(model.linearised(0.0, state)[0][size:], expected))
        result["jacobian_error"] = max(errors)
    return result


# --- record and page -----------------------------------------------------------------------------


def measure_all() -> Iterator[Record]:
    """Yield the record of all machines and programs, again after each."""
    began, rows, peer_rows = time.process_time() + _children_time(), list[Record](), list[Record]()
    listed = list_machines()
    names = [machine.name for machine in listed]
    record: Record = {"machines": names, "rows": rows, "peers": peer_rows}
    record["versions"] = find_versions()
    *quick, slow = [partial(_measure_machine, machine, record) for machine in listed]
    steps = [*quick]
    for program, measure, sizes in (
        ("MuJoCo", peers.measure_mujoco, CHAINS if peers.is_installed("mujoco") else ()),
        ("SymPy, Kane", peers.measure_kane, KANE),
    ):
        steps += [partial(_measure_peer, program, measure, links, record) for links in sizes]
    for step in (*steps, slow):
        step()
        record["cpu_s"] = time.process_time() + _children_time() - began
        yield record


def _measure_machine(machine: Machine, record: Record) -> None:
    record["rows"].append(measure_planter(machine))
    if (tree := _find_tree(machine)) is not None:
        record["peers"].append({"program": "Pinocchio", "machine": machine.name} | tree.measure())


def _measure_peer(
    program: str, measure: Callable[[int], dict[str, float]], links: int, record: Record
) -> None:
    row = {"program": program, "machine": f"chain of {links}"}
    record["peers"].append(row | measure(links))


def find_versions() -> dict[str, str]:
    """Return the processor's model and the versions of what runs."""
    processor = re.search(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text("utf-8"))
    model = re.search(r"model\s*: (.*)", Path("/proc/cpuinfo").read_text("utf-8"))
    family = re.search(r"cpu family\s*: (.*)", Path("/proc/cpuinfo").read_text("utf-8"))
    compiler = subprocess.run(["cc", "--version"], capture_output=True, text=True, check=True)
    assert processor
    assert model
    assert family
    return {
        "processor": f"{processor[1]} (family {family[1]}, model {model[1]})",
        "compiler": f"{compiler.stdout.splitlines()[0]} {' '.join(FLAGS)}",
        "python": platform.python_version(),
        "casadi": ca.CasadiMeta.version(),
        "numpy": np.__version__,
        **peers.find_versions(),
    }


def format_number(value: float | None) -> str:
    """Return a number with three digits; a dash for none."""
    if value is None:
        return "-"
    if 0 < abs(value) < 1e-3:
        return f"{value:.1e}"
    return f"{value:.3g}" if abs(value) < 1000 else f"{value:.0f}"


def count_lost_digits(error: float | None) -> str:
    """Return the digits of double precision that an error takes."""
    if error is None:
        return "-"
    return f"{max(0.0, np.log10(max(error, 1e-300) / np.finfo(float).eps)):.1f}"


COLUMNS = {
    "machine": "machine",
    "coordinates": "k",
    "constraints": "c",
    "derive_s": "derive / s",
    "module_kb": "module / kB",
    "compile_s": "compile f / s",
    "f_operations": "operations f",
    "f_ns": "f / ns",
    "f_python_ns": "f by Python / ns",
    "jacobian_operations": "operations A, B",
    "jacobian_compile_s": "compile A, B / s",
    "jacobian_ns": "A, B / ns",
    "jacobian_all_ns": "A, B, F / ns",
    "jacobian_python_ns": "A, B, F by Python / ns",
    "reference": "reference",
    "error": "error of f",
    "digits": "digits lost",
    "jacobian_error": "error of A",
}
PEER_COLUMNS = {
    "program": "program",
    "machine": "machine",
    "derive_s": "derive / s",
    "compile_s": "compile / s",
    "f_ns": "f / ns",
    "planter_ns": "f of planter / ns",
    "jacobian_ns": "A (B) / ns",
    "error": "error of f",
    "digits": "digits lost",
}


def render_table(columns: Mapping[str, str], rows: list[Record]) -> list[str]:
    """Return the lines of a table in Markdown."""
    lines = [f"| {' | '.join(columns.values())} |", f"|{'---|' * len(columns)}"]
    for row in rows:
        entries = {**row, "digits": count_lost_digits(row.get("error"))}
        cells = (entries.get(key) for key in columns)
        texts = (cell if isinstance(cell, str) else format_number(cell) for cell in cells)
        lines.append(f"| {' | '.join(texts)} |")
    return lines


def render_page(record: Record) -> str:
    """Return the part of the page that a record fills."""
    versions, times = record["versions"], {row["machine"]: row for row in record["rows"]}
    missing = [name for name in peers.NAMES if versions[name] == "not installed"]
    left_out = [name for name in record["machines"] if name not in times]
    measured = {row["program"] for row in record["peers"]}
    for program, distribution in (("MuJoCo", "mujoco"), ("SymPy, Kane", "sympy")):
        if program not in measured and distribution not in missing:
            left_out.append(program)
    peer_rows = [row | {"planter_ns": times[row["machine"]]["f_ns"]} for row in record["peers"]]
    overhead = max(row["f_python_ns"] - row["f_graph_ns"] for row in record["rows"])
    lines = [
        *render_table(COLUMNS, record["rows"]),
        "",
        f"A call by NumPy arrays takes at most {overhead / 1000:.1f} us more than CasADi's bare call of f.",
        "",
        *render_table(PEER_COLUMNS, peer_rows),
        "",
        f"Not installed, so not measured: {', '.join(missing) or 'none'}. "
        f"Left out by this run: {', '.join(left_out) or 'none'}.",
        "",
        f"{record['cpu_s']:.0f} CPU s in all. "
        + "; ".join(f"{key}: {value}" for key, value in versions.items() if key not in missing)
        + ".",
    ]
    return "\n".join(lines)


def fill_page(text: str, record: Record) -> str:
    """Return the page with the part of a record between its marks."""
    before, rest = text.split(BEGIN)
    return f"{before}{BEGIN}\n\n{render_page(record)}\n\n{END}{rest.split(END)[1]}"


def main() -> None:
    """Measure, unless the record is only to be written into the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--page", action="store_true", help="write the page of the record alone")
    if not parser.parse_args().page:
        for record in measure_all():
            RECORD.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
    record = json.loads(RECORD.read_text(encoding="utf-8"))
    PAGE.write_text(fill_page(PAGE.read_text("utf-8"), record), encoding="utf-8")


if __name__ == "__main__":
    main()
