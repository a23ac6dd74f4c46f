"""Functions of graphs for JAX: one operation a line, with equal bodies in loops, whose compilation
takes the time of one body.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

import casadi as ca

from planter.exports.dialect import JAX
from planter.exports.rolling import Loop, LoopFinder
from planter.kernels.lane_graph import OPERATIONS, ArrayElement, Assignment, LaneGraph

Value = tuple[str, int | None]
"""A name or constant, with its place where it is an array."""

IMPORTS = "import jax.numpy as jnp\nfrom jax import lax"
HELPERS = '''def _unify(*parts):
    """Return arrays of one type of numbers."""
    parts = [jnp.asarray(part) for part in parts]
    kind = jnp.result_type(float, *parts)
    return [part.astype(kind) for part in parts]


def _guard(function, x, low, high):
    """Return values of a function; outside of its range that of the nearest end, without a slope:
    jax.grad multiplies slopes of branches that do not hold by 0, which must not be NaN.
    """
    inside = (low < x) & (x < high)
    end = function(lax.stop_gradient(jnp.clip(x, low, high)))
    return jnp.where(inside, function(jnp.where(inside, x, 0.5)), end)


def _sqrt(x):
    return _guard(jnp.sqrt, x, 0.0, jnp.inf)


def _log(x):
    return _guard(jnp.log, x, jnp.finfo(x.dtype).tiny, jnp.inf)


def _asin(x):
    return _guard(jnp.arcsin, x, -1.0, 1.0)


def _acos(x):
    return _guard(jnp.arccos, x, -1.0, 1.0)


def _pow(x, exponent):
    low = jnp.where(exponent == jnp.floor(exponent), -jnp.inf, 0.0)
    return _guard(lambda base: jnp.power(base, exponent), x, low, jnp.inf)
'''


_SELECT = OPERATIONS[ca.OP_IF_ELSE_ZERO]
_GUARDED = [OPERATIONS[code] for code in (ca.OP_SQRT, ca.OP_LOG, ca.OP_ASIN, ca.OP_ACOS, ca.OP_POW)]
"""Operations that `HELPERS` has too."""


def guard_branches(graph: LaneGraph) -> LaneGraph:
    """Return a graph whose branches have values also where they do not hold."""
    users: dict[str, list[Assignment]] = {}
    for assignment in graph.assignments:
        for name in assignment.arguments:
            users.setdefault(name, []).append(assignment)
    results, masked = {store.value for store in graph.stores}, set()
    for assignment in reversed(graph.assignments):
        name = assignment.name
        if name not in results and all(
            user.name in masked or (user.source == _SELECT and user.arguments[0] != name)
            for user in users.get(name, ())
        ):
            masked.add(name)
    assignments = tuple(
        replace(assignment, source=replace(assignment.source, text=f"_{assignment.source.text}"))
        if assignment.name in masked and assignment.source in _GUARDED
        else assignment
        for assignment in graph.assignments
    )
    return replace(graph, assignments=assignments)


class JaxPrinter:
    """The text of a function."""

    def __init__(self, function: ca.Function) -> None:
        self.function = function
        self.graph = guard_branches(LaneGraph.from_function(function, ()))
        self.finder = LoopFinder(self.graph)
        self.values: dict[int, Value] = {}
        last = len(self.graph.assignments)
        uses = [(s.value, last) for s in self.graph.stores]
        for number, assignment in enumerate(self.graph.assignments):
            uses += ((name, number) for name in assignment.arguments)
        self.users: dict[int, int] = {}
        """The last assignment that uses each one; one behind all for results."""
        for name, user in uses:
            if name in self.finder.places:
                place = self.finder.places[name]
                self.users[place] = max(user, self.users.get(place, 0))

    def print_function(self) -> str:
        """Return a definition."""
        names = ", ".join(self.function.name_in())
        lines = [f"def {self.function.name()}({names}):", f"    {names} = _unify({names})"]
        loops = {loop.first: loop for loop in self.finder.loops}
        number = 0
        while number < len(self.graph.assignments):
            if number in loops:
                lines += _Block(self, loops[number]).list_lines()
                number = loops[number].end
            else:
                lines.append(self._print_assignment(number))
                number += 1
        results = []
        for name in self.function.name_out():
            values = [self.find_value(s.value) for s in self.graph.stores if s.place.name == name]
            results.append(print_value(values[0]) if name == "pivot" else print_array(values))
        return "\n".join([*lines, f"    return {', '.join(results)}", "", ""])

    def find_value(self, name: str) -> Value:
        """Return the value of a name; a constant is its own."""
        places = self.finder.places
        return self.values[places[name]] if name in places else (name, None)

    def _print_assignment(self, number: int) -> str:
        assignment = self.graph.assignments[number]
        self.values[number] = (assignment.name, None)
        arguments = [print_value(self.find_value(name)) for name in assignment.arguments]
        return JAX.assign(assignment, arguments)


def print_value(value: Value) -> str:
    """Return the text of a value."""
    return value[0] if value[1] is None else f"{value[0]}[{value[1]}]"


def print_array(values: Sequence[Value]) -> str:
    """Return the text of an array of values; neighbours of one array are taken together."""
    parts = []
    for is_scalar, group in itertools.groupby(values, key=lambda value: value[1] is None):
        if is_scalar:
            parts.append(f"jnp.stack([{', '.join(text for text, _ in group)}])")
        else:
            for text, places in itertools.groupby(group, key=lambda value: value[0]):
                parts.append(text + _index([place or 0 for _, place in places]))
    return parts[0] if len(parts) == 1 else f"jnp.concatenate([{', '.join(parts)}])"


def _index(places: Sequence[int]) -> str:
    """Return the index of several places of an array."""
    first, last = places[0], places[-1]
    if list(places) == list(range(first, last + 1)):
        return f"[{first}:{last + 1}]"
    if list(places) == list(range(first, last - 1, -1)):
        return f"[{first}:{last - 1}:-1]" if last else f"[{first}::-1]"
    return f"[jnp.array({list(places)})]"


def _print_tuple(names: Iterable[str]) -> str:
    """Return a tuple."""
    return "(" + "".join(f"{name}, " for name in names).rstrip() + ")"


class _Block:
    """The assignments of a loop's first block, with texts for arguments from elsewhere: `rows` have
    a value for each block, `carried` are values of blocks before, by assignment and distance.
    """

    def __init__(self, printer: JaxPrinter, loop: Loop) -> None:
        self.printer, self.loop = printer, loop
        self.rows: dict[tuple[Value, ...], str] = {}
        self.carried: dict[tuple[int, int], str] = {}
        self.lines = [self._print_assignment(offset) for offset in range(loop.period)]

    def _print_assignment(self, offset: int) -> str:
        loop, assignments = self.loop, self.printer.graph.assignments
        numbers = range(loop.first + offset, loop.end, loop.period)
        blocks = [assignments[number] for number in numbers]
        sources = [block.source for block in blocks]
        elements = [(s.name, s.index) for s in sources if isinstance(s, ArrayElement)]
        if elements:
            return JAX.statement.format(blocks[0].name, self._print_row(tuple(elements)))
        names = zip(*(block.arguments for block in blocks), strict=True)
        return JAX.assign(blocks[0], [self._print_argument(n) for n in names])

    def _print_argument(self, names: tuple[str, ...]) -> str:
        """Return the text of an argument from its names in all blocks."""
        places, loop = self.printer.finder.places, self.loop
        if names[-1] not in places or places[names[-1]] < loop.first:
            values = tuple(self.printer.find_value(name) for name in names)
            return print_value(values[0]) if len(set(values)) == 1 else self._print_row(values)
        place = places[names[0]]
        distance = max(0, -((place - loop.first) // loop.period))
        place += distance * loop.period
        for steps in range(1, distance + 1):
            self.carried.setdefault((place, steps), f"{self._name(place)}_before{steps}")
        return self.carried[place, distance] if distance else self._name(place)

    def _name(self, place: int) -> str:
        return self.printer.graph.assignments[place].name

    def _print_row(self, values: tuple[Value, ...]) -> str:
        return self.rows.setdefault(values, f"row{len(self.rows)}")

    def list_lines(self) -> Iterator[str]:
        """Yield statements: operations on arrays, or a scan if blocks need those before them.

        Arrays have the name of their first value with `_all`.
        """
        loop = self.loop
        offsets = [offset for offset in range(loop.period) if self._is_used_behind(offset)]
        names = [self._name(loop.first + offset) for offset in offsets]
        arrays = [f"{name}_all" for name in names]
        inputs = {row: print_array(values) for values, row in self.rows.items()}
        if self.carried:
            yield from self._print_scan(names, arrays, inputs)
        else:
            yield from (f"    {row} = {text}" for row, text in inputs.items())
            yield from self.lines
            yield from (f"    {a} = {name}" for a, name in zip(arrays, names, strict=True))
        for offset, array in zip(offsets, arrays, strict=True):
            numbers = range(loop.first + offset, loop.end, loop.period)
            self.printer.values |= {n: (array, turn) for turn, n in enumerate(numbers)}

    def _is_used_behind(self, offset: int) -> bool:
        loop, users = self.loop, self.printer.users
        numbers = range(loop.first + offset, loop.end, loop.period)
        return any(users.get(number, 0) >= loop.end for number in numbers)

    def _print_scan(
        self, names: Sequence[str], arrays: Sequence[str], inputs: dict[str, str]
    ) -> Iterator[str]:
        loop = self.loop
        moved, starts = [], []
        for place, steps in self.carried:
            moved.append(self._name(place) if steps == 1 else self.carried[place, steps - 1])
            start = self.printer.values[place - steps * loop.period]
            starts.append(f"jnp.asarray({print_value(start)}, x.dtype)")
        yield f"    def step{loop.first}(carried, rows):"
        yield f"        {_print_tuple(self.carried.values())} = carried"
        yield f"        {_print_tuple(inputs)} = rows" if inputs else "        del rows"
        yield from (f"    {line}" for line in self.lines)
        yield f"        return {_print_tuple(moved)}, {_print_tuple(names)}"
        yield f"    start = {_print_tuple(starts)}"
        yield "    rows = (" if inputs else "    rows = None"
        yield from (f"        {text}," for text in inputs.values())
        yield from ["    )"] * bool(inputs)
        results = _print_tuple(arrays)
        yield f"    _, {results} = lax.scan(step{loop.first}, start, rows, {loop.count})"
