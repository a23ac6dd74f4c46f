"""Sine, cosine, floor as C text that a compiler can put into a vector loop.

A compiler merges `sin(x)` and `cos(x)` into one call that no vector library has, and every call makes it spill all
registers. Where the processor has a fused multiply-add, both are printed out instead, from one reduction of the angle:
x = k pi + r with |r| <= pi/2, k pi subtracted in parts (Cody and Waite, Software Manual for the Elementary
Functions, 1980), then Taylor's series in r, whose first term left out is below 1e-17. WebAssembly, which has no fused
multiply-add, takes parts of pi so short that their products with k are exact. Elsewhere both are library calls, kept
apart by a zero that the compiler cannot see through. Floor has no vector instruction before SSE4.1; there
it goes by way of integers, and numbers beyond these, which are no angles any more, are left as they are.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from math import factorial, pi

PI_REST = 1.2246467991473532e-16
"""What pi has beyond the double nearest to it."""
SHORT_PI = (3.1415926218032837, 3.1786509424591713e-08)
"""That double in two parts of at most 27 bits: their products with k are exact up to k = 2^26."""
TERMS = 11


@dataclass(frozen=True)
class _Arithmetic:
    """How a b + c is written, and what `within` gives back."""

    multiply_add: str
    within: str

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
INLINED double within(double x, double k) {{ return {self.within}; }}
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
PARTED = _Arithmetic("(({}) * ({}) + ({}))", f"((x - k * {SHORT_PI[0]!r}) - k * {SHORT_PI[1]!r}) - k * {PI_REST!r}")


def fused() -> str:
    """`turned_sin` and `turned_cos` by fused multiply-adds; INLINED stands before each."""
    return FUSED.text()


def _library(name: str) -> str:
    return f"""\
double {name}_zero = 0.0;
INLINED double turned_sin(double x) {{ return sin(x); }}
INLINED double turned_cos(double x) {{ return cos(x + {name}_zero); }}
"""


def source(name: str, wasm: bool = False) -> str:
    """Definitions of `turned_sin`, `turned_cos`, `whole_floor`; `name` is put before what other files can see.

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
{fused()}#else
{PARTED.text() if wasm else _library(name)}#endif
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
