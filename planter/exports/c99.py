"""A machine as self-contained C: a header with units and equations, the kernels, and a small
program.

The templates are in the folder of this file: `machine.h`, `machine.c`, `loops.c`, `objective.c`,
`main.c`.
"""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Sequence
from functools import cached_property
from importlib import resources
from string import Template
from typing import Any

import casadi as ca

from planter.engine import loops as engine_loops
from planter.engine.loops import KinematicLoops
from planter.engine.machine import LEAST_PIVOT, Machine, Value
from planter.engine.response import MachineResponse
from planter.exports.quantities import (
    STATISTICS,
    SampledGoal,
    SideQuantity,
    build_cycle,
    build_headline,
    build_name,
    build_prologues,
    list_fixed,
    list_quantities,
)
from planter.kernels import Array, lane_source
from planter.kernels.lane_graph import LaneGraph
from planter.kernels.lane_source import print_function
from planter.version import __version__

STATUSES = {
    "NOT_FINITE": "a result is not finite",
    "NOT_CLOSED": (
        "the loops do not close over the turn: the machine has a dead point, or cannot be assembled"
    ),
    "NOT_RETURNED": "after a turn the loops are not what they were",
    "UNDETERMINED": "the balances do not determine the forces",
    "STUCK": "friction holds the machine fast",
}
"""Status codes of functions, from 1 on, with their meanings."""
CHUNK = 32
"""Angles at which loops are closed and forces proved determined before all quantities are computed
there.
"""
PLACES = 361
"""Places of a turn at which loops are closed first."""
WIDTH = 116


def build_source_files(machine: Machine) -> dict[str, str]:
    """Return the texts by file name: `NAME.h`, `NAME.c`, `NAME_main.c`.

    Raises InputError for an objective of what the machine does not have.
    """
    text = MachineText(machine)
    parts = {
        ".h": ("machine.h", text.header()),
        ".c": ("machine.c", text.source()),
        "_main.c": ("main.c", text.program()),
    }
    return {
        text.name + end: read_template(template).substitute(text.common | fields)
        for end, (template, fields) in parts.items()
    }


def build_casadi_text(file: str, both: Iterable[ca.Function]) -> str:
    """Return CasADi's C of functions; its helpers carry the file's name, so that they meet no
    others.
    """
    generator = ca.CodeGenerator(f"{file}.c")
    for function in both:
        generator.add(function)
    return str(generator.dump())


def build_loops_text(loops_: KinematicLoops, name: str) -> str:
    """Return what closes loops, in C, behind the kernels `newton` and `assemble`."""
    fields = {
        "coordinates": loops_.size,
        "loops": loops_.count,
        "angular": ", ".join(str(int(unit == "rad")) for unit in loops_.units),
        "places": PLACES,
        "turn": repr(engine_loops.TURN),
        "largest_step": repr(engine_loops.LARGEST_STEP),
        "least_step": repr(engine_loops.LEAST_STEP),
        "most_iterations": engine_loops.MOST_ITERATIONS,
        "singular": repr(engine_loops.SINGULAR),
        "closed": repr(engine_loops.CLOSED),
        "returned": repr(engine_loops.RETURNED),
        "not_closed": f"{name}_NOT_CLOSED",
        "not_returned": f"{name}_NOT_RETURNED",
    }
    return read_template("loops.c").substitute(fields)


class MachineText:
    """Values of the templates for a machine."""

    def __init__(self, machine: Machine) -> None:
        self.machine, self.name = machine, build_name(machine)
        self.goal = SampledGoal(machine)
        self.response = self.goal.response
        self.coordinates = machine.loops.size if machine.loops else 0
        self.has_objective = bool(self.goal.measures)
        self.guards = [guard.name for guard in machine.guards]
        self.quantities = list_quantities(machine)
        self.fixed = list_fixed(machine)
        self.lanes = len(self.response.offsets) * len(self.goal.phi)

    @cached_property
    def common(self) -> dict[str, Any]:
        """Values that several templates have in common."""
        return {
            **describe_machine(self.machine),
            "name": self.name,
            "NAME": self.name.upper(),
            "turn": repr(float(self.machine.turn)),
            "samples": "samples",
            "design_size": self._size("PARAMETERS", len(self.machine.moved)),
            "machine_size": self._size("MACHINE", len(self.fixed)),
        }

    def _size(self, word: str, count: int) -> str:
        """Return an array's size, at least one as the language asks."""
        return f"{self.name.upper()}_{word}" if count else "1"

    # --- the header
    # ------------------------------------------------------------------------------------------

    def header(self) -> dict[str, Any]:
        """Return what `machine.h` asks for."""
        machine, goal, name, big = self.machine, self.goal, self.name, self.name.upper()
        sides, count = len(machine.offsets), sum(not q.total for q in machine.results)
        work = {
            key: max(int(getattr(f, f"sz_{key}")()) for f in self.prologues) + 1
            for key in ("arg", "res", "iw")
        }
        statuses = ", ".join(f"{big}_{status} = {i}" for i, status in enumerate(STATUSES, 1))
        order = "Side 1 comes first, then the others in their order, then what all do together."
        loops_note = (
            f" Loops are closed from place to place over a turn: {big}_NOT_CLOSED where "
            f"they do not close."
        )
        return {
            "parameters": len(machine.moved),
            "constants": len(self.fixed),
            "samples": goal.samples,
            "angles": goal.angles,
            "side": count,
            "totals": len(machine.results) - count,
            "sides": sides,
            "statuses": statuses,
            "fields": ";\n  ".join(self._fields()),
            **work,
            "quantities": list_lines("Quantities q:", _number_quantities(self.quantities)),
            "equations": describe_equations(machine),
            "sides_order": _fill_comment(f" {order}") if sides > 1 else "",
            "loops_note": _fill_comment(loops_note) if self.coordinates else "",
            "scope": self._scope(),
            "found": self._found_text(),
            "after": self._after_text(),
            "objective": read_template("objective.h").substitute(name=name)
            if self.has_objective
            else "",
        }

    def _scope(self) -> str:
        if self.has_objective:
            return "; the objective over a turn, and its gradient."
        reason = self.goal.reason_missing
        return f".\n{wrap_comment(f'No objective: {reason}')}" if reason else "."

    def _found_text(self) -> str:
        if not self.has_objective:
            return ""
        names = ", ".join(self.goal.fields)
        sum_ = (
            f"Objective {self.goal.text}, in units of the machine's file; range, variance and "
            f"mean of rows [SI]."
        )
        return "\n".join(
            [
                "/* A turn of samples.",
                wrap_comment(sum_),
                " */",
                "typedef struct {",
                f"  double {names};",
                f"}} {self.name}_found;",
                "",
                "",
            ]
        )

    def _after_text(self) -> str:
        if not self.has_objective:
            return ""
        goal, big = self.goal, self.name.upper()
        rows = ", ".join(f"{row.label} [{row.quantity.unit}]" for row in goal.rows)
        part = f", 1/{len(self.machine.offsets)} of a turn: the rest is the same" * (
            goal.angles < goal.samples
        )
        return _fill_comment(
            f" After a call `samples` holds {rows} at the first {big}_ANGLES of `phi`{part}."
        )

    def _fields(self) -> list[str]:
        """Return the members of the memory, numbers first."""
        prologue = self.prologues[1]
        sizes = {
            "d": len(self.machine.values),
            "h": prologue.nnz_out(0),
            "dh": prologue.nnz_out(1),
            "w": max(int(f.sz_w()) for f in self.prologues) + 1,
        }
        if self.has_objective:
            rows = len(self.goal.rows) * self.lanes
            sizes = {
                "phi": self.lanes,
                "samples": rows,
                "weights": rows,
                "g": rows * (1 + len(self.machine.moved)),
            } | sizes
            if self.coordinates:
                sizes["coordinates"] = self.coordinates * self.lanes
        if self.is_in_chunks:
            sizes |= {
                "part": len(self.quantities) * CHUNK,
                "places": self.coordinates * CHUNK,
                "guards": len(self.guards) * max(CHUNK, self.lanes * self.has_objective),
            }
        if self.machine.loops:
            # senses, gains and places (`loops.c`)
            loops = self.machine.loops
            sizes["course"] = loops.count + (1 + PLACES) * loops.size
        numbers = ", ".join(f"{name}[{max(size, 1)}]" for name, size in sizes.items())
        return [f"double {numbers}", *(["int followed"] if self.coordinates else [])]

    # --- the source
    # ------------------------------------------------------------------------------------------

    def source(self) -> dict[str, Any]:
        """Return what `machine.c` asks for."""
        machine, big = self.machine, self.name.upper()
        return {
            "prologue": build_casadi_text(f"{self.name}_prologue", self.prologues),
            "kernels": self._kernels(),
            "own": join_numbers(machine.design),
            "lower": join_numbers(machine.lower),
            "upper": join_numbers(machine.upper),
            "data": join_numbers(machine.data[self.fixed]),
            "quantity": quote_strings(quantity.name for quantity in self.quantities),
            "values": len(machine.values),
            "design_places": join_integers(machine.moved),
            "machine_places": join_integers(self.fixed),
            "guards": self._guards_text(),
            "status": "int status" if self.is_in_chunks else "const int status",
            "failures": quote_strings(["there is a result", *STATUSES.values()]),
            "loops": build_loops_text(machine.loops, big) if machine.loops else "",
            "follow": _FOLLOW if machine.loops else "",
            "tangent_word": "`tangent`",
            "tangent": self._tangent_text(),
            "cycle": self._cycle_text(),
            "evaluation": self._evaluation_text(),
        }

    @cached_property
    def prologues(self) -> list[ca.Function]:
        """`hoisting` and `prologue`."""
        return build_prologues(self.machine, self.response.tangent)

    def _kernels(self) -> str:
        """Return all lane kernels as functions of this file alone."""
        lanes = [name for name in ("phi", "q") if name == "phi" or self.coordinates]
        printed = [(build_cycle(self.machine), lanes)]
        if self.machine.loops:
            printed += [
                (self.machine.loops.steps_function, []),
                (self.machine.loops.start_function, []),
            ]
        if self.guards:
            guards = MachineResponse(self.machine, self.guards).values_function
            inputs = guards.sx_in()
            printed.append(
                (
                    ca.Function("guards", inputs, guards.call(inputs), guards.name_in(), ["rows"]),
                    lanes,
                )
            )
        if self.has_objective:
            printed += [
                (self.response.values_function, lanes),
                (self.response.slopes_function, lanes),
                (self.goal.function, []),
            ]
        graphs = [LaneGraph.from_function(function, names) for function, names in printed]
        return "\n".join(
            [
                lane_source.print_functions(self.name),
                *(f"static {print_function(g, summed=False)}" for g in graphs),
            ]
        )

    @property
    def is_in_chunks(self) -> bool:
        """Whether quantities are computed a few angles at a time."""
        return bool(self.coordinates or self.guards)

    def _guards_text(self) -> str:
        if not self.guards:
            return ""
        kinds = join_integers(
            int(self.machine.find_quantity(name).role == "states") for name in self.guards
        )
        fields = {
            "name": self.name,
            "NAME": self.name.upper(),
            "guards": len(self.guards),
            "kinds": kinds,
            "least_pivot": repr(LEAST_PIVOT),
        }
        return Template(_GUARDS).substitute(fields)

    def _tangent_text(self) -> str:
        call = "(m->arg, m->res, m->iw, m->w, 0)"
        failed = f"{self.name.upper()}_NOT_FINITE : 0;\n"
        if self.has_objective:
            return (
                f"  m->res[1] = m->dh;\n  return (tangent ? prologue : hoisting){call} ? {failed}"
            )
        return f"  (void)tangent;\n  return hoisting{call} ? {failed}"

    def _cycle_text(self) -> str:
        """Return what fills q: all angles at once, or a few after the other where loops are closed
        before.
        """
        big, sides = self.name.upper(), len(self.machine.offsets)
        check = (
            f"  for (long i = 0; i < angles; ++i)\n    if (!is_finite(phi[i])) return "
            f"{big}_NOT_FINITE;\n"
        )
        start, count = ("m->part", "count") if self.is_in_chunks else ("q", "angles")
        outputs = [start, f"{start} + {big}_SIDE * {count}"]
        outputs += [f"{start} + {k} * {big}_SIDE * {count}" for k in range(2, sides + 1)]
        # the last is behind all sides, for what they do together
        places = ", ".join(outputs if self.machine.totals else outputs[:sides])
        if not self.is_in_chunks:
            return f"{check}  cycle(angles, phi, m->d, m->h, NULL, {places});"
        fields = {
            "chunk": CHUNK,
            "NAME": big,
            "outputs": places,
            "place": _CHUNK_PLACES if self.coordinates else "",
            "guard": _CHUNK_GUARDS if self.guards else "",
        }
        return check + Template(_CHUNKS).substitute(fields)

    def _evaluation_text(self) -> str:
        """Return the objective with what prepares the memory."""
        reset = "  m->followed = 0;\n" if self.coordinates else ""
        if not self.has_objective:
            nothing = reset or "  (void)m;\n"
            return f"void {self.name}_prepare({self.name}_memory *m)\n{{\n{nothing}}}\n"
        goal = self.goal
        results = ["objective"]
        for k in range(len(goal.rows)):
            high, low, mean, variance = (
                f"statistics[{len(STATISTICS) * k + i}]" for i in range(len(STATISTICS))
            )
            results += [f"{high} - {low}", variance, mean]
        coordinates = "m->coordinates" if self.coordinates else "NULL"
        return read_template("objective.c").substitute(
            self.common
            | {
                "rows": len(goal.rows),
                "shares": len(self.response.offsets),
                "nodes": len(goal.nodes),
                "shared": join_integers(int(row.shared) for row in goal.rows),
                "absolute": join_integers(int(row.absolute) for row in goal.rows),
                "node_rows": join_integers(row for row, _ in goal.nodes),
                "node_angles": join_numbers([angle for _, angle in goal.nodes]),
                "offsets": join_numbers(self.response.offsets),
                "count": goal.samples,
                "reset": reset,
                "coordinates": coordinates,
                "found": ", ".join(results),
                "place": _PLACE if self.coordinates else "",
                "guard": _GUARD.replace("COORDINATES_OF", coordinates) if self.guards else "",
            }
        )

    # --- the program
    # -----------------------------------------------------------------------------------------

    def program(self) -> dict[str, Any]:
        """Return what `main.c` asks for."""
        turn = f" *     ./{self.name} turn     all quantities over a turn, as CSV"
        if not self.has_objective:
            return {
                "usage": turn.replace(" turn ", "      ", 1),
                "objective": "",
                "first": "quantities",
            }
        formats = "".join(f"{printed} %.17g\\n" for printed in self.goal.fields.values())
        values = {
            "names": quote_strings(self.machine.design_names) or '""',
            "formats": formats,
            "numbers": ", ".join(f"found.{name}" for name in self.goal.fields),
        }
        objective = read_template("main_objective.c").substitute(self.common | values)
        return {
            "usage": f" *     ./{self.name}          objective and gradient\n{turn}",
            "objective": objective,
            "first": "objective",
        }


_FOLLOW = """\
  if (!m->followed || memcmp(m->d, d, sizeof d)) {
    m->followed = 0;
    const int status = follow_loops(d, m->course);
    if (status) return status;
    m->followed = 1;
  }
"""
_CHUNKS = """\
  for (long first = 0; first < angles; first += $chunk) {
    const long count = angles - first < $chunk ? angles - first : $chunk;
$place$guard    cycle(count, phi + first, m->d, m->h, m->places, $outputs);
    for (int k = 0; k < ${NAME}_QUANTITIES; ++k) memcpy(q + k * angles + first, m->part + k * count, count * sizeof *q);
  }"""
_CHUNK_PLACES = """\
    for (long i = 0; i < count; ++i) {
      double place[COORDINATES];
      if ((status = place_loops(m->d, m->course, phi[first + i], place))) return status;
      for (int k = 0; k < COORDINATES; ++k) m->places[k * count + i] = place[k];
    }
"""
_CHUNK_GUARDS = (
    "    if ((status = check_guards(m, count, phi + first, m->places))) return status;\n"
)
_PLACE = """\
  for (long i = 0; i < LANES; ++i) {
    double place[COORDINATES];
    const int missing = place_loops(m->d, m->course, m->phi[i], place);
    if (missing) return missing;
    for (int k = 0; k < COORDINATES; ++k) m->coordinates[k * LANES + i] = place[k];
  }
"""
_GUARD = """\
  const int undetermined = check_guards(m, LANES, m->phi, COORDINATES_OF);
  if (undetermined) return undetermined;
"""
_GUARDS = """\
/* Whether forces are determined: pivots (0) are not zero, states of friction (1) are there. */
static int check_guards(${name}_memory *m, long count, const double *phi, const double *coordinates)
{
  static const int kinds[$guards] = {$kinds};
  guards(count, phi, m->d, m->h, coordinates, m->guards);
  for (int k = 0; k < $guards; ++k)
    for (long i = 0; i < count; ++i) {
      const double value = m->guards[k * count + i];
      if (!is_finite(value)) return ${NAME}_NOT_FINITE;
      if (kinds[k] ? value == 0.0 : value < $least_pivot) return kinds[k] ? ${NAME}_STUCK : ${NAME}_UNDETERMINED;
    }
  return 0;
}
"""


def _fill_comment(text: str) -> str:
    """Return a sentence that continues a comment on new lines."""
    return f"\n{wrap_comment(text)}"


def read_template(file: str) -> Template:
    """Return a template of this package by its file name."""
    return Template(resources.files(__package__).joinpath(file).read_text(encoding="utf-8"))


def describe_machine(machine: Machine) -> dict[str, str]:
    """Return lines of comments: `headline`, `version`, and each number of `design` and
    `machine`.
    """
    fixed = [machine.values[index] for index in list_fixed(machine)]
    moved = [machine.values[index] for index in machine.moved]
    return {
        "headline": to_plain(build_headline(machine)),
        "version": __version__,
        "design": list_lines(
            "Design x:", _number_values(moved, [value.key for value in moved], "x")
        ),
        "machine": list_lines(
            "Machine:", _number_values(fixed, [value.path for value in fixed], "machine")
        ),
    }


def describe_equations(machine: Machine) -> str:
    """Return where the model comes from, what it assumes, and its equations, as lines of
    comments.
    """
    reference, assumptions = machine.documentation.reference, "; ".join(machine.assumptions)
    parts = [
        *([f"Source: {reference}."] if reference else []),
        *([f"Assumes: {assumptions}."] if assumptions else []),
    ]
    return "\n".join(
        [*map(wrap_comment, parts), list_lines("Equations:", machine.documentation.equations)]
    )


def list_lines(title: str, lines: Iterable[str]) -> str:
    """Return lines of a comment below a title."""
    wrapped = [wrap_comment(line, "    ") for line in lines]
    return "\n".join([f" * {title}{'' if wrapped else ' none'}", *wrapped])


def wrap_comment(text: str, indent: str = "") -> str:
    """Return a text as lines of a comment."""
    return textwrap.fill(
        to_plain(text),
        WIDTH,
        initial_indent=f" * {indent}",
        subsequent_indent=f" *   {indent}",
        break_long_words=False,
        break_on_hyphens=False,
    )


def to_plain(text: str) -> str:
    """Return a text in a line that ends no comment, starts none, and has no trigraph."""
    for mark in ("*/", "/*", "??"):
        text = text.replace(mark, " ".join(mark))
    return " ".join(text.split())


def quote_strings(names: Iterable[str]) -> str:
    """Return names as C strings."""
    return ", ".join('"' + name.replace("\\", "\\\\").replace('"', '\\"') + '"' for name in names)


def join_numbers(values: Array | Sequence[float]) -> str:
    """Return numbers in full precision, a zero for an empty array."""
    return ", ".join(repr(float(value)) for value in values) or "0.0"


def join_integers(numbers: Iterable[int]) -> str:
    """Return integers for an array, a zero for an empty array."""
    return ", ".join(str(int(number)) for number in numbers) or "0"


def _number_values(values: Sequence[Value], paths: Sequence[str], vector: str) -> Iterable[str]:
    for index, (value, path) in enumerate(zip(values, paths, strict=True)):
        source = f" ({value.source})" if value.source else ""
        yield f"{vector}[{index}] {path}: {value.name} [{value.unit}] {value.meaning}{source}"


def _number_quantities(quantities: Sequence[SideQuantity]) -> Iterable[str]:
    for index, entry in enumerate(quantities):
        q = entry.quantity
        side = f"; side {entry.side}" if entry.side and entry.sides > 1 else ""
        source = f" ({q.source})" if q.source else ""
        yield f"q[{index}] {entry.name} [{q.unit}] {q.meaning}{side}{source}"
