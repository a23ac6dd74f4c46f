"""Lane graphs as C99: a loop over lanes that a compiler turns into vector instructions.

    void NAME(long lanes, const double *restrict phi, const double *restrict x, ..., double
    *restrict force, ...)

An input that varies has a row of `lanes` numbers for each of its elements, one that does not its
elements column by column; an output has a row for each element or, summed, the sum of each over the
lanes.
A compiler merges `sin(x)` and `cos(x)` into one call that no vector library has, and every call
makes it spill all registers. Where the processor has a fused multiply-add, both are printed
instead, from one reduction of the angle: x = k pi + r with |r| <= pi/2, k pi subtracted in parts
(Cody and Waite, Software Manual for the Elementary Functions, 1980), then Taylor's series in r,
whose first omitted term is below 1e-17. WebAssembly, which has no fused multiply-add, takes parts
of pi so short that their products with k are exact. Elsewhere both are library calls, separated by
a zero that the compiler cannot see through. Floor has no vector instruction before SSE4.1; there it
is taken by way of integers, and numbers too large to be angles are not changed.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import factorial, pi

import casadi as ca

from planter.kernels.lane_graph import ArrayElement, Assignment, LaneGraph, OutputStore

PI_REST = 1.2246467991473532e-16
"""What pi has beyond the double nearest to it."""
SHORT_PI = (3.1415926218032837, 3.1786509424591713e-08)
"""That double in two parts of at most 27 bits: their products with k are exact up to k = 2^26."""
TERMS = 11


@dataclass(frozen=True)
class _Arithmetic:
    """Rules for printing a b + c and the result of `reduced`."""

    multiply_add: str
    reduced: str

    def sum(self, a: str, b: str, c: str) -> str:
        return self.multiply_add.format(a, b, c)

    def series(self, first: int, count: int) -> str:
        """Sum of (-1)^j q^j / (first + 2j)! by Horner's rule."""
        terms = [float(Fraction((-1) ** j, factorial(first + 2 * j))) for j in range(count)]
        text = repr(terms[-1])
        for term in reversed(terms[:-1]):
            text = self.sum(text, "q", repr(term))
        return text

    def text(self) -> str:
        """`turned_sin` and `turned_cos`."""
        return f"""\
INLINED double half_turns(double x) {{ return rint(x * {1 / pi!r}); }}
INLINED double within(double x, double k) {{ return {self.reduced}; }}
INLINED double parity(double k) {{ const double h = 0.5 * k; return {self.sum("-4.0", "fabs(h - rint(h))", "1.0")}; }}
INLINED double turned_sin(double x)
{{
  const double k = half_turns(x), r = within(x, k), q = r * r;
  return parity(k) * r * ({self.series(1, TERMS)});
}}
INLINED double turned_cos(double x)
{{
  const double k = half_turns(x), r = within(x, k), q = r * r;
  return parity(k) * ({self.series(0, TERMS + 1)});
}}
"""


FUSED = _Arithmetic("fma({}, {}, {})", f"fma(-k, {PI_REST!r}, fma(-k, {pi!r}, x))")
SPLIT = _Arithmetic(
    "(({}) * ({}) + ({}))", f"((x - k * {SHORT_PI[0]!r}) - k * {SHORT_PI[1]!r}) - k * {PI_REST!r}"
)


def _print_library_calls(name: str) -> str:
    return f"""\
double {name}_zero = 0.0;
INLINED double turned_sin(double x) {{ return sin(x); }}
INLINED double turned_cos(double x) {{ return cos(x + {name}_zero); }}
"""


def print_functions(name: str, wasm: bool = False) -> str:
    """Definitions of `turned_sin`, `turned_cos`, `whole_floor`; `name` is put before what other
    files can see.

    Those for WebAssembly want a compiler that does not reorder sums.
    """
    return f"""\
#if defined(__GNUC__)
#define INLINED static inline __attribute__((always_inline, unused))
#else
#define INLINED static inline
#endif
#if defined(__clang__)
#define INDEPENDENT_LANES _Pragma("clang loop interleave(disable)")
#elif defined(__GNUC__)
#define INDEPENDENT_LANES _Pragma("GCC ivdep")
#else
#define INDEPENDENT_LANES
#endif
#if defined(FP_FAST_FMA) || defined(__FMA__)
{FUSED.text()}#else
{SPLIT.text() if wasm else _print_library_calls(name)}#endif
#if defined(__SSE2__) && !defined(__SSE4_1__)
INLINED double whole_floor(double x)
{{
  const double near = fmin(fmax(x, -2147483647.0), 2147483647.0), whole = (double)(int)near;
  return near == x ? whole - (whole > near ? 1.0 : 0.0) : x;
}}
#else
INLINED double whole_floor(double x) {{ return floor(x); }}
#endif
"""


def print_file(graphs: Sequence[LaneGraph], summed: Sequence[bool], wasm: bool = False) -> str:
    """A C file with a lane kernel for each graph, for WebAssembly or any other processor."""
    kernels = [print_function(graph, total) for graph, total in zip(graphs, summed, strict=True)]
    return "\n".join(
        ["#include <math.h>\n", print_functions(graphs[0].function.name(), wasm), *kernels]
    )


def print_prototype(f: ca.Function) -> str:
    """The head of a kernel's function, without a semicolon."""
    inputs = [f"const double *restrict {name}" for name in f.name_in()]
    outputs = [f"double *restrict {name}" for name in f.name_out()]
    return f"void {f.name()}(long lanes, {', '.join([*inputs, *outputs])})"


def print_function(graph: LaneGraph, summed: bool) -> str:
    """The kernel: what all lanes share, then the loop; `summed` outputs are added up over the
    lanes.
    """
    totals = [f"a{index}" for index in range(len(graph.stores))] if summed else []
    lines = [print_prototype(graph.function), "{"]
    lines += [f"  {_print_assignment(a)}" for a in graph.invariant]
    lines += [f"  double {name} = 0.0;" for name in totals]
    lines += ["INDEPENDENT_LANES", "  for (long i = 0; i < lanes; ++i) {"]
    lines += [f"    {line}" for line in (_print_sums(graph) if summed else _print_stores(graph))]
    lines += ["  }"]
    lines += [
        f"  {s.place.name}[{s.place.index}] = {name};"
        for s, name in zip(graph.stores, totals, strict=False)
    ]
    unused = _print_unused(graph)
    lines[2:2] = [f"  (void){name};" for name in unused]
    return "\n".join([*lines, "}", ""])


def _print_stores(graph: LaneGraph) -> Iterable[str]:
    """Assignments of the loop; a result is stored as soon as it is computed, which frees its
    register.
    """
    waiting: dict[str, list[OutputStore]] = {}
    for store in graph.stores:
        waiting.setdefault(store.value, []).append(store)
    for assignment in graph.varying:
        yield _print_assignment(assignment)
        yield from (_print_store(store) for store in waiting.pop(assignment.name, []))
    yield from (_print_store(store) for stores in waiting.values() for store in stores)


def _print_sums(graph: LaneGraph) -> Iterable[str]:
    yield from (_print_assignment(assignment) for assignment in graph.varying)
    yield from (f"a{index} += {store.value};" for index, store in enumerate(graph.stores))


def _print_assignment(assignment: Assignment) -> str:
    if isinstance(assignment.source, ArrayElement):
        value = _print_element(assignment.source, assignment.varies)
    else:
        value = assignment.source.text.format(*assignment.arguments)
    return f"const double {assignment.name} = {value};"


def _print_store(store: OutputStore) -> str:
    return f"{_print_element(store.place, varies=True)} = {store.value};"


def _print_element(place: ArrayElement, varies: bool) -> str:
    if not varies:
        return f"{place.name}[{place.index}]"
    return f"{place.name}[i]" if place.scalar else f"{place.name}[{place.index} * lanes + i]"


def _print_unused(graph: LaneGraph) -> list[str]:
    """Inputs that the function does not depend on."""
    read = {a.source.name for a in graph.assignments if isinstance(a.source, ArrayElement)}
    return [name for name in graph.function.name_in() if name not in read]
