"""Graphs as C99: a loop over lanes that a compiler turns into vector instructions.

    void NAME(long lanes, const double *restrict phi, const double *restrict x, ..., double *restrict force, ...)

An input that varies holds a row of `lanes` numbers for each of its elements, one that does not an element after the
other, column by column; an output holds a row for each element or, summed, the sum of each over the lanes.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import casadi as ca

from planter.kernels.loops import functions
from planter.kernels.loops.graph import Assignment, Graph, Place, Store


def file(graphs: Sequence[Graph], summed: Sequence[bool], wasm: bool = False) -> str:
    """A C file with a lane kernel for each graph, for WebAssembly or any other processor."""
    kernels = [function(graph, total) for graph, total in zip(graphs, summed, strict=True)]
    return "\n".join(["#include <math.h>\n", functions.source(graphs[0].function.name(), wasm), *kernels])


def prototype(f: ca.Function) -> str:
    """The head of a kernel's function, without a semicolon."""
    inputs = [f"const double *restrict {name}" for name in f.name_in()]
    outputs = [f"double *restrict {name}" for name in f.name_out()]
    return f"void {f.name()}(long lanes, {', '.join([*inputs, *outputs])})"


def function(graph: Graph, summed: bool) -> str:
    """The kernel: what all lanes share, then the loop; `summed` outputs are added up over the lanes."""
    totals = [f"a{index}" for index in range(len(graph.stores))] if summed else []
    lines = [prototype(graph.function), "{"]
    lines += [f"  {_assigned(a)}" for a in graph.invariant]
    lines += [f"  double {name} = 0.0;" for name in totals]
    lines += ["INDEPENDENT_LANES", "  for (long i = 0; i < lanes; ++i) {"]
    lines += [f"    {line}" for line in (_summing(graph) if summed else _storing(graph))]
    lines += ["  }"]
    lines += [f"  {s.place.name}[{s.place.index}] = {name};" for s, name in zip(graph.stores, totals, strict=False)]
    unused = _unused(graph)
    lines[2:2] = [f"  (void){name};" for name in unused]
    return "\n".join([*lines, "}", ""])


def _storing(graph: Graph) -> Iterable[str]:
    """Assignments of the loop; a result is stored as soon as it is there, so that it need not be kept."""
    waiting: dict[str, list[Store]] = {}
    for store in graph.stores:
        waiting.setdefault(store.value, []).append(store)
    for assignment in graph.varying:
        yield _assigned(assignment)
        yield from (_stored(store) for store in waiting.pop(assignment.name, []))
    yield from (_stored(store) for stores in waiting.values() for store in stores)


def _summing(graph: Graph) -> Iterable[str]:
    yield from (_assigned(assignment) for assignment in graph.varying)
    yield from (f"a{index} += {store.value};" for index, store in enumerate(graph.stores))


def _assigned(assignment: Assignment) -> str:
    if isinstance(assignment.source, Place):
        value = _element(assignment.source, assignment.varies)
    else:
        value = assignment.source.text.format(*assignment.arguments)
    return f"const double {assignment.name} = {value};"


def _stored(store: Store) -> str:
    return f"{_element(store.place, varies=True)} = {store.value};"


def _element(place: Place, varies: bool) -> str:
    if not varies:
        return f"{place.name}[{place.index}]"
    return f"{place.name}[i]" if place.scalar else f"{place.name}[{place.index} * lanes + i]"


def _unused(graph: Graph) -> list[str]:
    """Inputs that the function does not depend on."""
    read = {a.source.name for a in graph.assignments if isinstance(a.source, Place)}
    return [name for name in graph.function.name_in() if name not in read]
