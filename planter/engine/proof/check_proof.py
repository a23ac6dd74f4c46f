"""Check a proof that `planter optimise --prove` wrote, without planter: python check_proof.py
proof.json [PROCESSES] [--machine generated/array/NAME.py]

Every bound of every box, the covering of the box by its parts, and the upper bound of the incumbent
are computed again from the programs in the file, in the ball arithmetic of Arb (pip install
python-flint). A valid claim is printed in words; the last line is `valid` or the reason. Exit code
0 valid, 1 refused, 2 not readable. docs/proof.md of planter states the theorems.

Functions of the design x and of the place s in a panel of angles are jets: value and gradient at
the centre of a box, value, gradient and Hessian anywhere in it. Then f(x) is in f(c) + f'(c) d + d'
H d / 2, and f'(x) in f'(c) + H d.
"""

import argparse
import ast
import functools
import hashlib
import importlib.util
import inspect
import itertools
import json
import math
import random
import re
import sys
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from fractions import Fraction
from pathlib import Path

try:
    from flint import arb, arb_mat, arb_poly, ctx

    ONE, ZERO, UNIT, INFINITY = arb(1), arb(0), arb(0, 1), arb("inf")
except ImportError:  # what a file states takes no arithmetic: planter has these rules from here
    if __name__ == "__main__":
        raise

FORMAT, MOST_PIECES = "planter proof 3", 64
MOST_STEPS, SMALL_STEP, WAYS, OVERLAP = 30, 1e-9, 16, 1e-9
PARTS, MEANT, TRIALS, SAME = (48, 192), 1e-6, 8, 1e-7
MOST_SAMPLES, MOST_PANELS, LARGEST_POWER, LONGEST_FRACTION = 100_000, 100_000, 1000, 40
SIDES, NONNEGATIVE = (
    {"max": (1,), "min": (-1,), "range": (1, -1)},
    ("range", "variance", "std", "rms"),
)
MEASURES = (*SIDES, "mean", "variance", "std", "rms", "at")
KINDS = {
    "format": str,
    "planter": str,
    "statement": str,
    "generated": dict,
    "parameters": list,
    "quantities": list,
    "kind": str,
    "samples": (int, type(None)),
    "response": dict,
    "assembly": (dict, type(None)),
    "machine": dict,
    "scales": list,
    "trusted": list,
    "terms": list,
    "limits": list,
    "all_limits": bool,
    "box": list,
    "incumbent": dict,
    "lower_bound": (str, type(None)),
    "nodes": list,
    "sha256": str,
}
TEXTS = {"format", "planter", "statement", "trusted", "generated", "machine"}
TEXTS |= {"parameters", "quantities", "sha256"}
LOGIC = ("or", "and", "not")
OPERATIONS = {
    "multiply",
    "add",
    "negate",
    "power",
    "polynomial",
    "input",
    "constant",
    "pi",
    "select",
}
OPERATIONS |= {"arctan2", "floor", "below", "solve", *LOGIC}


class RefusedError(ValueError):
    """A statement of a file does not follow."""


class NoBound(ArithmeticError):
    """A quantity has no bound over a box at some angle."""


def refuse_unless(holds, reason):
    """Raise RefusedError with a reason unless a statement holds."""
    if not holds:
        raise RefusedError(reason)


def map_ends(function, x):
    """Return the values of an increasing function over a ball, by those at its ends."""
    return function(x) if x.is_exact() else function(x.lower()).union(function(x.upper()))


def sine_ball(x, shift):
    """Return sin(x + shift pi / 2), whose second derivative is at most 1."""
    middle, radius = arb(x.mid()), arb(x.rad())
    sin, cos = (middle.cos(), -middle.sin()) if shift else (middle.sin(), middle.cos())
    return (sin + UNIT * (abs(cos) * radius + radius * radius / 2)).intersection(UNIT)


def raise_ball(x, n):
    """Return x^n; Arb's own has no value where x may vanish."""
    return math.prod([x] * n, start=ONE)


def square_ball(x):
    """Return x^2, which is nowhere negative."""
    return raise_ball(x.abs_lower(), 2).union(raise_ball(x.abs_upper(), 2))


def turn_angle(turn):
    """Return an angle [rad] for a fraction of a turn."""
    return 2 * arb.pi() * turn.numerator / turn.denominator


FUNCTIONS = {  # f(x), f'(x) from x and f(x), f''(x) from x, f(x) and f'(x)
    "inverse": (lambda x: 1 / x, lambda _, y: -y * y, lambda x, y, d: 2 * y * y * y),
    "sqrt": (
        lambda x: map_ends(arb.sqrt, x),
        lambda _, y: 1 / (2 * y),
        lambda x, y, d: -d / (2 * x),
    ),
    "log": (lambda x: map_ends(arb.log, x), lambda x, _: 1 / x, lambda x, y, d: -d * d),
    "exp": (lambda x: map_ends(arb.exp, x), lambda _, y: y, lambda x, y, d: y),
    "sin": (lambda x: sine_ball(x, 0), lambda x, _: sine_ball(x, 1), lambda x, y, d: -y),
    "cos": (lambda x: sine_ball(x, 1), lambda x, _: -sine_ball(x, 0), lambda x, y, d: -y),
    "arctan": (
        lambda x: map_ends(arb.atan, x),
        lambda x, _: 1 / (1 + square_ball(x)),
        lambda x, y, d: -2 * x * d * d,
    ),
}


class BoxSpace:
    """A box with half widths `radii` of what moves in it, the place in a panel from -1 to 1 as the
    last if `panels`.
    """

    def __init__(self, lower, upper, panels):
        self.cutting, self.panels, self.centre = (
            True,
            panels,
            [a + (b - a) / 2 for a, b in zip(lower, upper)],
        )
        self.open = [k for k, (a, b) in enumerate(zip(lower, upper)) if a < b]
        centre = [arb(x) for x in self.centre]
        self.radii = [
            max(upper[k] - centre[k], centre[k] - lower[k]).upper() for k in self.open
        ] + [ONE] * panels
        self.n = n = len(self.radii)
        self.delta = arb_mat(n, 1, [UNIT * radius for radius in self.radii])
        self.zeros = arb_mat(n, 1), arb_mat(n, 1), arb_mat(n, n)

    def constant(self, value):
        """Return a function that is the same everywhere."""
        return BallJet(self, arb(value), arb(value))

    def linear(self, value, rates, place=0):
        """Return a function that is linear in the design, with rates in all of its parameters, and
        in the place.
        """
        slope = arb_mat(self.n, 1, [rates[k] for k in self.open] + [place] * self.panels)
        return BallJet(
            self,
            arb(value),
            value + (slope.transpose() * self.delta)[0, 0],
            slope,
            slope,
            self.zeros[2],
        )

    def parameters(self):
        """Return the parameters of the design as functions."""
        return [
            self.linear(x, [i == k for i in range(len(self.centre))])
            if k in self.open
            else self.constant(x)
            for k, x in enumerate(self.centre)
        ]


class BallJet:
    """Value and gradient at the centre (c, gc) and anywhere (v, g), and Hessian h; constants have
    no derivatives.

    Value and gradient anywhere of an open jet are intersected with the Taylor form about the centre
    when they are asked for; sums take them as they are, which costs less and loses little.
    """

    __slots__ = ("_g", "_v", "c", "gc", "h", "is_open", "space")

    def __init__(self, space, c, v, gc=None, g=None, h=None, is_open=False):
        self.space, self.c, self._v, self.gc, self._g, self.h = space, c, v, gc, g, h
        self.is_open = is_open

    @property
    def v(self):
        self.close()
        return self._v

    @property
    def g(self):
        self.close()
        return self._g

    @property
    def derivatives(self):
        return self.space.zeros if self.gc is None else (self.gc, self.g, self.h)

    def cut(self):
        """Open the jet where Taylor forms apply."""
        self.is_open = self.gc is not None and self.space.cutting
        return self

    def close(self):
        """Intersect value and gradient anywhere with the Taylor form about the centre."""
        if self.is_open:
            moved, delta = self.h * self.space.delta, self.space.delta
            self._v = self._v.intersection(
                self.c + ((self.gc + moved * arb(0.5)).transpose() * delta)[0, 0]
            )
            self._g = arb_mat(
                self.space.n,
                1,
                [*map(arb.intersection, self._g.entries(), (self.gc + moved).entries())],
            )
            self.is_open = False

    def meet(self, value):
        """Intersect the value anywhere with another enclosure of it."""
        self._v = self.v.intersection(value)

    def __neg__(self):
        rest = () if self.gc is None else (-self.gc, -self._g, -self.h, self.is_open)
        return BallJet(self.space, -self.c, -self._v, *rest)

    def __add__(self, other):
        a, b = (other, self) if self.gc is None else (self, other)
        c, v = a.c + b.c, a._v + b._v
        if b.gc is None:
            return BallJet(a.space, c, v, a.gc, a._g, a.h, a.is_open)
        return BallJet(a.space, c, v, a.gc + b.gc, a._g + b._g, a.h + b.h).cut()

    def __sub__(self, other):
        return self + -other

    def __mul__(self, other):
        a, b = (other, self) if self.gc is None else (self, other)
        if b.gc is None:
            parts = () if a.gc is None else (a.gc * b.c, a._g * b._v, a.h * b._v, a.is_open)
            return BallJet(a.space, a.c * b.c, a._v * b._v, *parts)
        values = a.c * b.c, a.v * b.v
        mixed = a.g * b.g.transpose()
        return BallJet(
            a.space,
            *values,
            b.gc * a.c + a.gc * b.c,
            b.g * a.v + a.g * b.v,
            b.h * a.v + a.h * b.v + mixed + mixed.transpose(),
        ).cut()

    def apply(self, function, slope, bend):
        """Return f(x) from functions of x, of x and f(x), and of x, f(x) and f'(x)."""
        c, v = function(self.c), function(self.v)
        if self.gc is None:
            return BallJet(self.space, c, v)
        d = slope(self.v, v)
        hessian = self.h * d + (self.g * bend(self.v, v, d)) * self.g.transpose()
        return BallJet(self.space, c, v, self.gc * slope(self.c, c), self.g * d, hessian).cut()

    def call(self, name):
        """Return an elementary function of the jet."""
        if (name == "inverse" and self.v.contains(0)) or (
            name in ("sqrt", "log") and not self.v > 0
        ):
            raise NoBound(f"{name} has no bound")
        return self.apply(*FUNCTIONS[name])

    def __pow__(self, n):
        return self.apply(
            lambda x: raise_ball(x, n),
            lambda x, _: n * raise_ball(x, n - 1),
            lambda x, y, d: n * (n - 1) * raise_ball(x, max(n - 2, 0)),
        )

    def polynomial(self, numbers):
        """Return the sum of a_k x^k, highest power first, expanded about the centre."""
        middle = arb(self.c.mid())
        value = arb_poly(numbers[::-1])(arb_poly([middle, 1]))
        slope, bend = value.derivative(), value.derivative().derivative()
        return self.apply(
            lambda x: value(x - middle),
            lambda x, _: slope(x - middle),
            lambda x, y, d: bend(x - middle),
        )

    def angle(self, x):
        """Return the angle of the point (x, self): that of a fixed direction near it plus the angle
        from there.
        """
        if not (x.v > 0 or self.v > 0 or self.v < 0):
            raise NoBound("an angle may jump by a turn")
        turn = math.atan2(float(self.c.mid()), float(x.c.mid()))
        cos, sin = self.space.constant(math.cos(turn)), self.space.constant(math.sin(turn))
        ratio = (self * cos - x * sin) * (x * cos + self * sin).call("inverse")
        return ratio.call("arctan") + self.space.constant(arb.atan2(sin.c, cos.c))

    def lower_bound(self):
        """Return a number below the jet over the box."""
        change, radii = ZERO, self.space.radii
        for i in range(self.space.n if self.gc is not None else 0):
            change += radii[i] * abs(self.gc[i, 0]) + radii[i] ** 2 / 2 * max(
                -self.h[i, i].lower(), ZERO
            )
            change += sum((radii[i] * radii[j] * abs(self.h[i, j]) for j in range(i)), ZERO)
        return max((self.c - change.upper()).lower(), self.v.lower())

    def without_place(self, change, tilt):
        """Return the jet without the place in a panel, by what its slope and bend change it, and
        mixed ones slopes.
        """
        if self.gc is None or not self.space.panels:
            return self
        n, last = self.space.n, self.space.n - 1
        keep = arb_mat(n, n, [float(i == j < last) for i in range(n) for j in range(n)])
        mixed = arb_mat(n, 1, [*(tilt(self.h[i, last]) for i in range(last)), ZERO])
        value = self.c + change(self.gc[last, 0], self.h[last, last])
        return BallJet(
            self.space, value, self.v, keep * self.gc + mixed, keep * self.g, keep * self.h * keep
        ).cut()

    def average(self):
        """Return the mean over a panel: terms odd in the place cancel but for what differs between
        pieces.
        """
        return self.without_place(
            lambda slope, bend: UNIT * slope.rad() / 2 + bend / 6, lambda x: UNIT * x.rad() / 2
        )

    def hull(self):
        """Return what the jet is at any one place of a panel, slope s + bend s^2 / 2 for s from -1
        to 1.
        """

        def parabola(slope, bend):
            steep = slope.abs_upper()
            high, low = (
                (steep**2 / (-2 * curve) if steep < -curve else steep + curve / 2).upper()
                for curve in (bend.upper(), -bend.lower())
            )
            return high.union(-low)

        return self.without_place(parabola, lambda x: UNIT * x.abs_upper())


def join_jets(jets, join):
    """Return a jet whose entries are those of all jets, joined."""
    space, n = jets[0].space, jets[0].space.n
    result = BallJet(space, join([jet.c for jet in jets]), join([jet.v for jet in jets]))
    if any(jet.gc is not None for jet in jets):
        parts = [
            [join(list(x)) for x in zip(*(jet.derivatives[k].entries() for jet in jets))]
            for k in range(3)
        ]
        result.gc, result._g, result.h = (
            arb_mat(n, columns, part) for columns, part in zip((1, 1, n), parts)
        )
    return result


def unite_jets(jets):
    """Return a jet around all jets."""
    return (
        jets[0]
        if len(jets) == 1
        else join_jets(jets, lambda balls: functools.reduce(arb.union, balls))
    )


def add_up(jets):
    """Return the sum of many jets."""
    return join_jets(jets, lambda balls: sum(balls, ZERO)).cut()


def invert_matrix(rows, part):
    """Return the inverse of a matrix of jets at the centre or anywhere (part c or v), if none of
    them is singular.
    """
    return arb_mat([[getattr(jet, part) for jet in row] for row in rows]).inv()


def enclose_roots(space, k, start, residual):
    """Return roots near a start, with points and radii of the balls of which Newton's interval step
    maps each into itself: they hold one root at each design.

    Derivatives solve f_a a' = -f_x and f_a a'' = -(f_xx + 2 f_xa a' + f_aa a' a'); the right sides
    are gradients of f with constants in place of roots, and Hessians along the lines a' (x - x*),
    where Taylor forms do not apply.
    """
    at, n = list(start), space.n

    def constants(values):
        return [space.constant(x) for x in values]

    def column(jets, part):
        return arb_mat(k, 1, [getattr(jet, part) for jet in jets])

    for _ in range(30):
        gaps, rows = residual(constants(at))
        step = invert_matrix(rows, "c") * column(gaps, "c")
        at = [float((x - step[i, 0]).mid()) for i, x in enumerate(at)]
        if all(step[i, 0].abs_upper() <= 1e-9 * abs(x) for i, x in enumerate(at)):
            break
    scale = constants(
        arb(x.mid()) for x in invert_matrix(residual(constants(at))[1], "c").entries()
    )

    def scaled(a):
        gaps, rows = residual(a)
        both = [
            [
                sum(
                    (scale[i * k + j] * row[m] for j, row in enumerate(zip(gaps, *zip(*rows)))),
                    space.constant(0),
                )
                for m in range(k + 1)
            ]
            for i in range(k)
        ]
        return [row[0] for row in both], [row[1:] for row in both]

    def contain(part):
        gaps = column(scaled(constants(at))[0], part)
        radii, moved = [ZERO] * k, [x.abs_upper() for x in gaps.entries()]
        for _ in range(30):
            radii = [
                r if m < r else 1.5 * m + 1e-15 * abs(x) + 1e-300
                for r, m, x in zip(radii, moved, at)
            ]
            balls = constants(x + UNIT * r for x, r in zip(at, radii))
            change = (invert_matrix(scaled(balls)[1], part) * gaps).entries()
            moved = [x.abs_upper() for x in change]
            if all(m < r for m, r in zip(moved, radii)):
                return [x - y for x, y in zip(at, change)], radii
        raise NoBound("no ball is mapped into itself by a Newton step")

    def divide(kind, jets, inverse):
        right = arb_mat([jet.derivatives[kind].entries() for jet in jets])
        result, columns = -(inverse * right), n if kind == 2 else 1
        return [arb_mat(n, columns, [result[i, m] for m in range(n * columns)]) for i in range(k)]

    (middle, _), (values, radii), jets = contain("c"), contain("v"), None
    centre_gaps, centre_rows = scaled(constants(middle))
    centre = divide(0, centre_gaps, invert_matrix(centre_rows, "c"))
    for _ in range(2):
        box_gaps, box_rows = scaled(constants(values))
        inverse = invert_matrix(box_rows, "v")
        rates = divide(1, box_gaps, invert_matrix(scaled(jets)[1], "v") if jets else inverse)
        space.cutting = False
        lines = [BallJet(space, v, v, rate, rate, space.zeros[2]) for v, rate in zip(values, rates)]
        bends = divide(2, scaled(lines)[0], inverse)
        space.cutting = True
        jets = [BallJet(space, *parts).cut() for parts in zip(middle, values, centre, rates, bends)]
        values = [jet.v for jet in jets]
    return jets, at, radii


def append_jacobian(steps: Iterable, outputs: Iterable, count: int) -> tuple:
    """Return the steps and the results of a program (name, arguments, numbers), followed by the
    derivatives of each result in the first `count` inputs.
    """
    steps = [(name, tuple(a), tuple(numbers)) for name, a, numbers in steps]
    indices = {step: n for n, step in reversed(list(enumerate(steps)))}

    def put(name, *arguments, numbers=()):
        step = (name, arguments, tuple(map(float, numbers)))
        if step not in indices:
            indices[step] = len(steps)
            steps.append(step)
        return indices[step]

    def number(value):
        return put("constant", numbers=[value])

    def times(a, b):
        return None if a is None or b is None else put("multiply", a, b)

    def plus(a, b):
        return (b if a is None else a) if a is None or b is None else put("add", a, b)

    def negative(a):
        return None if a is None else put("negate", a)

    def find_factor(n):
        """Return the derivative of an elementary function of one argument."""
        name, (x, *_), numbers = steps[n]
        if name == "power":
            low = [numbers[0] - 1]
            return put("multiply", number(numbers[0]), put("power", x, numbers=low))
        if name == "polynomial":
            total, rate = number(numbers[0]), None
            for factor in numbers[1:]:  # Horner's rule, and its derivative
                rate = plus(times(rate, x), total)
                total = put("add", put("multiply", total, x), number(factor))
            return rate
        return {
            "negate": lambda: number(-1),
            "inverse": lambda: negative(put("multiply", n, n)),
            "sqrt": lambda: put("inverse", put("add", n, n)),
            "log": lambda: put("inverse", x),
            "exp": lambda: n,
            "sin": lambda: put("cos", x),
            "cos": lambda: negative(put("sin", x)),
            "arctan": lambda: put("inverse", put("add", number(1), put("multiply", x, x))),
        }[name]()

    def find_slope(n, rates, place):
        """Return the derivative of a step from those of the earlier ones, None where it is zero."""
        name, a, numbers = steps[n]
        if name == "input":
            return number(1) if numbers[0] == place else None
        d = [rates[k] for k in a]
        if name == "solve":
            raise RefusedError("roots of simultaneous equations within others are not followed")
        if name in ("floor", "below", *LOGIC) or all(rate is None for rate in d):
            return None
        if name == "multiply":
            return plus(times(d[0], a[1]), times(a[0], d[1]))
        if name == "add":
            return plus(*d)
        if name == "select":
            return put("select", *(number(0) if rate is None else rate for rate in d[:2]), a[2])
        if name == "arctan2":
            size = put("add", put("multiply", a[0], a[0]), put("multiply", a[1], a[1]))
            return times(plus(times(a[1], d[0]), negative(times(a[0], d[1]))), put("inverse", size))
        return times(d[0], find_factor(n))

    length, columns = len(steps), []
    for place in range(count):
        rates = []
        for n in range(length):
            rates.append(find_slope(n, rates, place))
        columns.append(rates)
    slopes = [rates[k] for k in outputs for rates in columns]
    return steps, [*outputs, *(number(0) if rate is None else rate for rate in slopes)]


PLAIN = {  # operations in plain numbers, which prove nothing
    "multiply": lambda a, b: a * b,
    "add": lambda a, b: a + b,
    "negate": lambda a: -a,
    "select": lambda a, b, condition: a if condition else b,
    "arctan2": math.atan2,
    "floor": math.floor,
    "or": lambda *a: any(a),
    "and": lambda *a: all(a),
    "not": lambda a: not a,
    "pi": lambda: math.pi,
    "inverse": lambda a: 1 / a,
    "arctan": math.atan,
    **{name: getattr(math, name) for name in ("sqrt", "log", "exp", "sin", "cos")},
}


def evaluate_plainly(steps, outputs, inputs):
    """Return the results of a program in plain numbers, as hints for enclosures.

    Raises ArithmeticError or ValueError where it has none.
    """
    values = []
    for name, arguments, numbers in steps:
        a = [values[k] for k in arguments]
        match name:
            case "input":
                value = inputs[int(numbers[0])]
            case "constant":
                value = numbers[0]
            case "power":
                value = a[0] ** int(numbers[0])
            case "polynomial":
                value = functools.reduce(lambda total, factor: total * a[0] + factor, numbers)
            case "below":
                value = a[0] < 0 if numbers[0] else a[0] <= 0
            case "solve":
                size, k = map(int, numbers)
                *matrix, right = (a[i : i + size] for i in range(0, len(a), size))
                value = solve_plainly(matrix, right)[k]
            case _:
                value = PLAIN[name](*a)
        values.append(value)
    return [values[k] for k in outputs]


def solve_plainly(matrix, right):
    """Return the solution of simultaneous equations, by elimination with pivots."""
    rows, size = [[*row, value] for row, value in zip(matrix, right)], len(right)
    for k in range(size):
        pivot = max(range(k, size), key=lambda i: abs(rows[i][k]))
        rows[k], rows[pivot] = rows[pivot], rows[k]
        for i in range(k + 1, size):
            share = rows[i][k] / rows[k][k]
            rows[i] = [a - share * b for a, b in zip(rows[i], rows[k])]
    solution = []
    for k in reversed(range(size)):
        rest = sum(a * y for a, y in zip(rows[k][size - 1 : k : -1], solution))
        solution.append((rows[k][size] - rest) / rows[k][k])
    return solution[::-1]


def find_plainly(steps, outputs, guess, inputs):
    """Return roots by Newton's method in plain numbers; the results of the program are residuals
    and their Jacobian.

    Raises ArithmeticError where it does not converge.
    """
    q, size = list(guess), len(guess)
    for _ in range(MOST_STEPS):
        rows = evaluate_plainly(steps, outputs, [*q, *inputs])
        parts = [rows[i : i + size] for i in range(0, len(rows), size)]
        step = solve_plainly(parts[1:], parts[0])
        q = [x - y for x, y in zip(q, step)]
        if all(abs(y) <= SMALL_STEP * (1 + abs(x)) for x, y in zip(q, step)):
            return q
    raise ArithmeticError("Newton's method does not converge")


def follow_plainly(stages: Sequence, starts: Sequence, points: Sequence) -> list:
    """Return near roots, for each stage that has some, at points (design, angle) along a way.

    A stage is (steps, results, places of inputs, places of values, number of roots); the first
    roots are near `starts`, the others near those before. None stands where there are none, from
    there on.
    """
    way, roots = [], starts
    for x, phi in points:
        values, nearest = dict(enumerate([*x, phi])), []
        try:
            for steps, outputs, inputs, places, size in stages:
                arguments = [values[k] for k in inputs]
                if size:
                    nearest.append(find_plainly(steps, outputs, roots[len(nearest)], arguments))
                results = nearest[-1] if size else evaluate_plainly(steps, outputs, arguments)
                values.update(zip(places, results))
        except (ArithmeticError, ValueError):
            break
        roots = nearest
        way.append(roots)
    return way + [None] * (len(points) - len(way))


def list_cells(
    origin: Sequence, lower: Sequence, upper: Sequence, turn: float, count: int
) -> tuple:
    """Return the cells [low, high] of designs and an angle (the last entry) through which roots are
    followed from a design `origin` at the angle 0, and the points at their ends.

    The first cells hold all straight ways from the origin to a design of the box at that angle;
    they are one if the box holds the origin. `count` further ones hold the box and parts of a
    period. Neighbours share a point and a convex set, and each is a little wider than its part.
    """
    is_inside = all(low <= x <= high for low, x, high in zip(lower, origin, upper))
    shares = [0.0, 1.0] if is_inside else [k / WAYS for k in range(WAYS + 1)]
    centre, cells = [a + (b - a) / 2 for a, b in zip(lower, upper)], []

    def move(x, share):
        return x if share == 1 else [a + share * (b - a) for a, b in zip(origin, x)]

    def widen(side, way):
        return [
            x if a == b == c else x + way * OVERLAP * max(abs(a), abs(b), abs(c))
            for x, a, b, c in zip(side, origin, lower, upper)
        ]

    for part in itertools.pairwise(shares):
        corners = list(zip(*(move(end, share) for end in (lower, upper) for share in part)))
        sides = [widen(map(min, corners), -1), widen(map(max, corners), 1)]
        cells.append([[*side, 0.0] for side in ([lower, upper] if is_inside else sides)])
    points = [(move(centre, share), 0.0) for share in shares]
    for k in range(count):
        ends = k / count * turn - OVERLAP * turn, (k + 1) / count * turn + OVERLAP * turn
        cells.append([[*lower, ends[0]], [*upper, ends[1]]])
        points.append((centre, (k + 1) / count * turn))
    return cells, points


class ProofProgram:
    """Operations [name, arguments, numbers] in order; each condition is asked once."""

    def __init__(self, entry):
        self.steps = [
            (name, a, [float.fromhex(x) for x in numbers])
            for name, a, numbers in entry["operations"]
        ]
        self.outputs, self.size = entry["outputs"], len(entry["limits"])
        if self.size:
            self.steps, self.outputs = append_jacobian(self.steps, self.outputs, self.size)

    def run(self, space, inputs, script=()):
        """Return the results and, of each condition, answer, others and jumps; `script` gives the
        first answers.
        """
        values, conditions, solved = [], [], {}

        def answer(usual, low, high, jumps):
            if high - low >= 3:
                raise NoBound("a box goes through many branches")
            choice = (
                script[len(conditions)]
                if len(conditions) < len(script)
                else min(max(usual, low), high)
            )
            conditions.append((choice, [k for k in range(low, high + 1) if k != choice], jumps))
            return choice

        def solve(size, k, arguments):
            rows = [
                [values[a] for a in arguments[i : i + size]] for i in range(0, len(arguments), size)
            ]
            if arguments not in solved:
                start = (
                    invert_matrix(rows[:-1], "c") * arb_mat(size, 1, [jet.c for jet in rows[-1]])
                ).entries()
                solved[arguments], _, _ = enclose_roots(
                    space,
                    size,
                    [float(x.mid()) for x in start],
                    lambda q: (
                        [
                            add_up([a * y for a, y in zip(row, q)]) - b
                            for row, b in zip(rows, rows[-1])
                        ],
                        rows[:-1],
                    ),
                )
                *matrix, right = [[jet.v for jet in row] for row in rows]
                for algorithm in ("lu", "precond"):
                    direct = (
                        arb_mat(matrix)
                        .solve(arb_mat(size, 1, right), algorithm=algorithm)
                        .entries()
                    )
                    for y, value in zip(solved[arguments], direct):
                        y.meet(value)
            return solved[arguments][k]

        def floor(x):
            low, high = (int(float(end.floor())) for end in (x.lower(), x.upper()))
            return space.constant(answer(math.floor(float(x.mid())), low, high, True))

        def below(x, strictly, jumps):
            always, never = (x < 0, x >= 0) if strictly else (x <= 0, x > 0)
            return bool(answer(int(x.mid() < 0), int(always), int(not never), bool(jumps)))

        for name, arguments, numbers in self.steps:
            a = [values[k] for k in arguments]
            match name:
                case "multiply":
                    result = a[0] * a[1]
                case "add":
                    result = a[0] + a[1]
                case "negate":
                    result = -a[0]
                case "power":
                    result = a[0] ** int(numbers[0])
                case "polynomial":
                    result = a[0].polynomial(numbers)
                case "input":
                    result = inputs[int(numbers[0])]
                case "constant" | "pi":
                    result = space.constant(numbers[0] if numbers else arb.pi())
                case "select":
                    result = a[0] if a[2] else a[1]
                case "arctan2":
                    result = a[0].angle(a[1])
                case "floor":
                    result = floor(a[0].v)
                case "below":
                    result = below(a[0].v, *numbers)
                case "or" | "and":
                    result = (any if name == "or" else all)(a)
                case "not":
                    result = not a[0]
                case "solve":
                    result = solve(*map(int, numbers), tuple(arguments))
                case _:
                    result = a[0].call(name)
            values.append(result)
        return [values[k] for k in self.outputs], conditions

    def run_smooth(self, space, inputs):
        """Return the results where no condition has several answers over the box."""
        results, conditions = self.run(space, inputs)
        if any(alternatives for _, alternatives, _ in conditions):
            raise NoBound("a condition has several answers over a box")
        return results

    def find_roots(self, space, inputs, start):
        """Return the roots near a start, with points and radii of balls that hold no other."""

        def residual(q):
            rows, k = self.run_smooth(space, [*q, *inputs]), self.size
            return rows[:k], [rows[i : i + k] for i in range(k, k + k * k, k)]

        centre = [float(jet.c.mid()) for jet in inputs]
        guess = find_plainly(self.steps, self.outputs, start, centre)
        return enclose_roots(space, self.size, guess, residual)

    def run_pieces(self, space, inputs):
        """Return the hulls of all smooth pieces, and whether results may jump from one to the
        other.
        """
        pieces, scripts, jumps = [], [()], False
        while scripts:
            script = scripts.pop()
            results, conditions = self.run(space, inputs, script)
            pieces.append(results)
            for n, (_, alternatives, may_jump) in enumerate(conditions):
                jumps |= bool(alternatives) and may_jump
                answers = tuple(choice for choice, _, _ in conditions[:n])
                scripts += [(*answers, other) for other in alternatives] if n >= len(script) else []
            if len(pieces) > MOST_PIECES:
                raise NoBound("a box goes through many branches")
        return [unite_jets(results) for results in zip(*pieces)], jumps


class Response:
    """Quantities over boxes at angles, from the stages of programs in the file."""

    def __init__(self, entry):
        self.count, self.continuous = entry["parameters"], entry["continuous"]
        self.offsets, self.period = (
            [Fraction(x) for x in entry["offsets"]],
            Fraction(entry["period"]),
        )
        self.stages, moving, self.size = [], {self.count}, self.count + 1
        for stage in entry["stages"]:
            program, inputs = ProofProgram(stage), stage["inputs"]
            fixed = moving.isdisjoint(inputs)
            places = range(self.size, self.size + (program.size or len(program.outputs)))
            moving |= set() if fixed else set(places)
            self.stages.append((program, inputs, fixed, places))
            self.size = places.stop
        self.rooted = [fixed for program, _, fixed, _ in self.stages if program.size]
        needed, self.feeding = set(), []
        for stage in reversed(self.stages):
            if stage[0].size or needed.intersection(stage[3]):
                needed.update(stage[1])
                self.feeding.insert(0, stage)
        self.plain = [
            (program.steps, program.outputs, inputs, places, program.size)
            for program, inputs, _, places in self.feeding
        ]

    def find_roots(self, space, phi, guesses):
        """Return the roots of each stage near guesses, whichever they are."""
        values, roots = dict(enumerate([*space.parameters()[: self.count], phi])), []
        for program, inputs, _, places in self.feeding:
            arguments = [values[k] for k in inputs]
            if program.size:
                roots.append(program.find_roots(space, arguments, guesses[len(roots)]))
            results = roots[-1][0] if program.size else program.run_smooth(space, arguments)
            values.update(zip(places, results))
        return roots

    def advance(self, space, values, branch, phi=None):
        """Return values with the results of the stages that no angle changes, or of those that the
        angle phi does.
        """
        values, number = [*values, *[None] * (self.size - len(values))], 0
        if phi is not None:
            values[self.count] = phi
        for program, inputs, fixed, places in self.stages[:-1]:
            number += bool(program.size)
            if fixed is not (phi is None):
                continue
            arguments = [values[k] for k in inputs]
            if program.size:
                ball = branch.find_ball(number - 1, phi)
                results, _, _ = program.find_roots(space, arguments, ball[0])
                if not has_values(ball, [jet.c for jet in results]):
                    raise NoBound("the roots of a box are not those that are meant")
            else:
                results = program.run_smooth(space, arguments)
            values[places.start : places.stop] = results
        return values

    def enclose(self, space, fixed, branch, jumps, phi):
        """Return the quantities at an angle, or None without bounds; note whether they may jump
        over the designs.
        """
        sides = []
        for offset in self.offsets:
            try:
                values = self.advance(
                    space, fixed, branch, phi + space.constant(turn_angle(offset))
                )
                results, jump = self.stages[-1][0].run_pieces(
                    space, [values[k] for k in self.stages[-1][1]]
                )
            except ArithmeticError:
                return None
            sides.append(results)
            jumps.append(jump and not self.continuous)
        return [sum(shares[1:], shares[0]) for shares in zip(*sides)]


def has_values(ball, values):
    """Return whether a ball, points and radii, holds values."""
    return ball is not None and all(abs(value - x) <= r for x, r, value in zip(*ball, values))


class FollowedRoots:
    """The roots that are meant over a box, followed to it from the assembly in the file.

    Each of the equal parts of a period (one for roots that no angle changes) has balls with one
    root at every design, None where they were not followed to it. Families of regular roots that
    have one in common are the same wherever both are known.
    """

    def __init__(self, response, assembly, lower, upper):
        self.turn, self.parts = 2 * math.pi * float(response.period), []
        if assembly is None:
            return
        origin = [float.fromhex(x) for x in assembly["design"]]
        starts = [[float.fromhex(x) for x in roots] for roots in assembly["roots"]]
        for parts in PARTS if not all(response.rooted) else (0,):
            self.count = math.ceil(parts * response.period)
            cells, points = list_cells(origin, lower, upper, self.turn, self.count)
            reached = self._follow(response, starts, cells, points)
            if all(reached):
                break
        first = len(cells) - self.count
        for number, fixed in enumerate(response.rooted):
            part = reached[first - 1 : first] if fixed else reached[first:]
            self.parts.append([balls and balls[number] for balls in part])

    def _follow(self, response, starts, cells, points):
        """Return the balls of all cells, None where roots were not followed to them."""
        middles = [[(a + b) / 2 for a, b in zip(*cell)] for cell in cells]
        way = [points[0]]
        for middle, point in zip(middles, points[1:]):
            way += [(middle[:-1], middle[-1]), point]
        first, guesses = len(cells) - self.count, follow_plainly(response.plain, starts, way)

        def enclose(low, high, guesses):
            space = BoxSpace(low, high, 0)
            try:
                refuse_unless(guesses, "")
                return response.find_roots(space, space.parameters()[-1], guesses)
            except (ArithmeticError, RefusedError):
                return None

        def enclose_all(way):
            balls = [enclose(*cell, guesses) for cell, guesses in zip(cells, way[1::2])]
            ends = [enclose([*x, phi], [*x, phi], q) for (x, phi), q in zip(points, way[::2])]
            balls = [roots and [(at, radii) for _, at, radii in roots] for roots in balls]
            ends = [roots and [[jet.c for jet in jets] for jets, _, _ in roots] for roots in ends]
            return balls, ends

        def are_held(balls, values):
            return bool(balls and values) and all(map(has_values, balls, values))

        def join(balls, ends):
            return [are_held(*x) and are_held(x[0], y) for *x, y in zip(balls, ends, ends[1:])]

        balls, ends = enclose_all(guesses)
        is_meant = bool(ends[0]) and all(
            abs(x - value) <= MEANT * (1 + abs(x))
            for start, values in zip(starts, ends[0])
            for x, value in zip(start, values)
        )
        forward = itertools.accumulate(join(balls, ends), lambda a, b: a and b, initial=is_meant)
        reached = list(forward)[1:]
        if self.count == 0 or not all(reached[:first]):
            return [ball if is_known else None for ball, is_known in zip(balls, reached)]

        is_begun = are_held(balls[first], ends[first])

        def is_closed(ends):
            """Return whether the roots after a period are those at its begin, but for turns."""
            if not (is_begun and ends[-1]):
                return False
            turned = []
            for values, (at, _) in zip(ends[-1], balls[first]):
                turns = [
                    round(float((value.mid() - x) / (2 * arb.pi()))) for value, x in zip(values, at)
                ]
                turned.append([value - 2 * arb.pi() * n for value, n in zip(values, turns)])
            return are_held(balls[first], turned)

        if all(reached):
            return balls if is_closed(ends) else [None] * len(balls)
        back = follow_plainly(response.plain, guesses[2 * first], way[: 2 * first : -1])
        backs, ends = enclose_all([*guesses[: 2 * first + 1], *back[::-1]])
        joined = join(backs, ends)[::-1]
        backward = list(itertools.accumulate(joined, lambda a, b: a and b, initial=is_closed(ends)))
        return [
            ball if is_known else other if is_back else None
            for ball, other, is_known, is_back in zip(balls, backs, reached, backward[:0:-1])
        ]

    def find_ball(self, number, phi):
        """Return points and radii of the balls with the roots at angles, all of which are in parts
        to which roots were followed.
        """
        parts = self.parts[number]
        if len(parts) == 1:
            (ball,) = parts
        else:
            middle = float(phi.c.mid())
            count, fold = len(parts), math.floor(middle / self.turn) * self.turn
            ends = [(float(x) - fold) / self.turn for x in (phi.v.lower(), middle, phi.v.upper())]
            low, place, high = (math.floor(x * count) for x in ends)
            all_known = all(parts[k % count] for k in range(low, min(high, low + count) + 1))
            ball = parts[place % count] if all_known else None
        if ball is None:
            raise NoBound("loops are not closed in the assembly that is meant")
        return ball


def list_panels(space, entry, period):
    """Return the angles in panels and their shares; an end is the same function in both panels that
    meet there.
    """
    turn, knots, ends = turn_angle(period), list(zip(entry["knots"], entry["rates"])), []
    after = [*knots[1:], (knots[0][0] + float(turn.mid()), knots[0][1])]
    for (knot, rates), (end, last), count in zip(knots, after, entry["parts"], strict=True):
        ends += [
            space.linear(
                knot + i / count * (end - knot),
                [a + i / count * (b - a) for a, b in zip(rates, last)],
            )
            for i in range(count)
        ]
    ends.append(ends[0] + space.constant(turn))
    place, half = space.linear(0, [0] * len(space.centre), 1), space.constant(0.5)
    widths = [stop - start for start, stop in itertools.pairwise(ends)]
    if not all(width.v > 0 for width in widths):
        raise NoBound("panels of angles overlap")
    angles = [
        (start + stop + width * place) * half for start, stop, width in zip(ends, ends[1:], widths)
    ]
    return angles, [width * space.constant(1 / turn) for width in widths]


def is_nonnegative(term):
    """Return whether a term is nowhere below zero."""
    size = term["size"] and term["measure"] in ("max", "at")
    return (size or term["measure"] in NONNEGATIVE) and term["weight"] >= 0


class BoundedCycle:
    """Quantities over a box in the lanes of a cycle with their shares, at fixed angles, and at a
    few near extremes.
    """

    def __init__(self, proof, lower, upper, branch, evidence, key="panels"):
        response, self.proof, self.jumps = proof.response, proof, []
        self.space = space = BoxSpace(lower, upper, int(proof.samples is None))
        fixed = response.advance(space, space.parameters()[: response.count], branch)
        enclose = functools.partial(response.enclose, space, fixed, branch, self.jumps)
        if proof.samples is None:
            angles, self.shares = list_panels(space, evidence[key], response.period)
        else:
            angles = [space.constant(turn_angle(turn)) for turn in proof.list_samples()]
            self.shares = [space.constant(ONE / len(angles))] * len(angles)
        self.lanes = [enclose(phi) for phi in angles]
        self.fixed = [
            enclose(space.constant(turn_angle(Fraction(angle) / 360))) for angle in proof.angles
        ]
        points = [
            enclose(space.linear(*x))
            for x in zip(evidence.get("peaks", []), evidence.get("rates", []))
        ]
        count = len(points) // max(1, len(proof.extremes))
        self.points = {
            (k, side): [x[k] for x in points[i * count : (i + 1) * count] if x is not None]
            for i, (k, side) in enumerate(proof.extremes)
        }

    def take(self, measure):
        """Return the jets of a measure with their shares, and whether they are all."""
        place = None if measure["angle"] is None else self.proof.angles.index(measure["angle"])
        lanes, shares = (
            (self.lanes, self.shares) if place is None else ([self.fixed[place]], [None])
        )
        pairs = [
            (x[measure["quantity"]], share) for x, share in zip(lanes, shares) if x is not None
        ]
        return pairs, len(pairs) == len(lanes)

    def find_maximum(self, measure, side, weight=1):
        """Return points below the greatest value of a quantity, or of minus it, and its panels."""
        factor = self.space.constant(side * weight)
        panels = [jet.hull() * factor for jet, _ in self.take(measure)[0]]
        points = [point * factor for point in self.points[measure["quantity"], side]] or panels
        return sorted(points, key=lambda jet: -float(jet.c.mid())), panels

    def average(self, measure):
        """Return a measure without corners; squares that are missing count as zero."""
        pairs, complete = self.take(measure)
        if measure["measure"] == "at":
            return pairs[0][0]
        mean = add_up([jet.average() * share for jet, share in pairs])
        if measure["measure"] == "mean":
            return mean
        if measure["measure"] != "rms":
            mean = (
                mean if complete else mean * add_up([share for _, share in pairs]).call("inverse")
            )
            pairs = [(jet - mean, share) for jet, share in pairs]
        squares = [(jet**2, share, square_ball(jet.v)) for jet, share in pairs]
        for jet, _, value in squares:
            jet.meet(value)
        mean = add_up([jet.average() * share for jet, share, _ in squares])
        return mean if measure["measure"] == "variance" else mean.call("sqrt")

    def bound_terms(self):
        """Return the smooth part of the objective, its greatest values, and whether nothing is left
        out.
        """
        smooth, extremes, has_all = self.space.constant(0), [], True
        for term in self.proof.terms:
            (pairs, complete), sides = self.take(term), SIDES.get(term["measure"], ())
            if (not complete and not is_nonnegative(term) and not sides) or not any(self.lanes):
                raise NoBound("a measure has no bound without some of the angles")
            has_all &= complete
            try:
                extremes += [
                    self.find_maximum(term, side, abs(term["weight"])) for side in sides if pairs
                ]
                if pairs and not sides:
                    smooth += self.average(term) * self.space.constant(term["weight"])
            except ArithmeticError:
                if not is_nonnegative(term):
                    raise
                has_all = False
        return smooth, extremes, has_all

    def span(self, measure, part):
        """Return between which values a limited measure times its sign is, at the centre (c) or
        anywhere (v).
        """
        (pairs, complete), low, high = self.take(measure), ZERO, ZERO
        for side in SIDES.get(measure["measure"], ()) if pairs else ():
            points, panels = self.find_maximum(measure, side)
            low += max(getattr(jet, part).lower() for jet in points)
            high += max(getattr(jet, part).upper() for jet in panels)
        if measure["measure"] not in SIDES and pairs:
            value = getattr(self.average(measure), part)
            low, high = (
                value.lower() if complete or measure["measure"] in NONNEGATIVE else -INFINITY,
                value.upper(),
            )
        low, high = low if pairs else -INFINITY, high if complete else INFINITY
        return (
            (-high, -low) if (measure["measure"] == "min") is (measure["sign"] > 0) else (low, high)
        )


class ProofClaims:
    """Statements of a file, and the bounds that follow from its programs."""

    def __init__(self, document):
        def read(entry):
            angle, numbers = (
                entry["angle_deg"],
                {k: float.fromhex(entry[k]) for k in ("weight", "limit") if k in entry},
            )
            return {**entry, **numbers, "angle": None if angle is None else float.fromhex(angle)}

        self.response, self.samples = Response(document["response"]), document["samples"]
        self._assembly, self._branches = document["assembly"], {}
        self.terms, self.limits = (
            [read(entry) for entry in document[key]] for key in ("terms", "limits")
        )
        measures, self.all_limits = [*self.terms, *self.limits], document["all_limits"]
        self.extremes = list(
            dict.fromkeys((m["quantity"], x) for m in measures for x in SIDES.get(m["measure"], ()))
        )
        self.angles = list(dict.fromkeys(m["angle"] for m in measures if m["angle"] is not None))

    def list_samples(self):
        """Return the angles of samples that differ modulo the period [turns]."""
        cycle = max(Fraction(1), self.response.period)
        share = self.response.period / cycle * self.samples
        return [
            cycle * i / self.samples
            for i in range(int(share) if share.denominator == 1 else self.samples)
        ]

    def find_branch(self, lower, upper):
        """Return the roots that are meant over a box, remembered for its parts."""
        key = tuple(lower), tuple(upper)
        if key not in self._branches:
            self._branches[key] = FollowedRoots(self.response, self._assembly, lower, upper)
        return self._branches[key]

    def bound(self, lower, upper, domain, evidence):
        """Return a lower bound over a box, an upper one at its centre, slopes, and whether slopes
        decide nothing. The roots are those that were followed to all of a domain.
        """
        branch = self.find_branch(*domain)
        cycle = BoundedCycle(self, lower, upper, branch, evidence)
        numbers = [limit["sign"] * limit["limit"] for limit in self.limits]
        anywhere, centre = ([cycle.span(limit, part) for limit in self.limits] for part in "vc")
        if any(low > number for (low, _), number in zip(anywhere, numbers)):
            return INFINITY, INFINITY, {}, True
        free, met = (
            all(high <= x for (_, high), x in zip(spans, numbers)) for spans in (anywhere, centre)
        )
        smooth, extremes, entire = cycle.bound_terms()
        if "narrow" in evidence:
            point = BoundedCycle(
                self,
                cycle.space.centre,
                cycle.space.centre,
                branch,
                {**evidence, "peaks": []},
                "narrow",
            )
            smooth.c = smooth.c.intersection(point.bound_terms()[0].c)
            smooth = smooth.cut()
        count = int(60 ** (1 / max(1, len(extremes))))
        choices = itertools.product(*(points[:count] for points, _ in extremes))
        lowest = max(sum(choice, smooth).lower_bound() for choice in choices)
        reached, slopes = smooth.c, smooth.derivatives[1]
        for points, panels in extremes:
            reached += max(panel.c.upper() for panel in panels)
            slopes += unite_jets(
                [jet for jet in panels if not (points[0] - jet).lower_bound() > 0]
            ).derivatives[1]
        reached = reached.upper() if entire and met and self.all_limits else INFINITY
        return (
            lowest,
            reached,
            dict(zip(cycle.space.open, slopes.entries())),
            any(cycle.jumps) or not (entire and free),
        )


def list_boxes(document):
    """Yield place, node, box and inherited bound of all nodes; refuse boxes that are not covered by
    their parts.
    """
    nodes, seen = document["nodes"], {0}
    floor = 0.0 if all(map(is_nonnegative, PROOF.terms)) else -math.inf
    waiting = [(0, *([float.fromhex(x) for x in end] for end in document["box"]), floor)]
    boxes = {}
    while waiting:
        place, lower, upper, best = waiting.pop()
        node, boxes[place] = nodes[place], (lower, upper)
        domain = boxes.get(node.get("evidence", {}).get("continued", place))
        is_held = domain is not None and all(
            a <= b <= c <= d for a, b, c, d in zip(domain[0], lower, upper, domain[1])
        )
        refuse_unless(is_held, f"nodes[{place}] is not in the box to which roots were followed")
        best = max(best, float.fromhex(node.get("bound", "-inf")))
        yield place, node, lower, upper, domain, best
        children, parts = node.get("children", []), []
        if "split" in node:
            k, at = node["split"][0], float.fromhex(node["split"][1])
            refuse_unless(lower[k] <= at <= upper[k], f"nodes[{place}] is split outside of its box")
            parts = [
                (lower, [*upper[:k], at, *upper[k + 1 :]]),
                ([*lower[:k], at, *lower[k + 1 :]], upper),
            ]
        elif "sides" in node:
            fixed = {k: (lower if side == "lower" else upper)[k] for k, side in node["sides"]}
            parts = [[[fixed.get(k, x) for k, x in enumerate(end)] for end in (lower, upper)]]
        is_covered = len(parts) == len(children) and not seen.intersection(children)
        refuse_unless(is_covered, f"nodes[{place}] has other children than its parts")
        has_claims = "bound" in node or "sides" in node
        refuse_unless(
            "evidence" in node or not has_claims, f"nodes[{place}] has claims without evidence"
        )
        seen.update(children)
        waiting += [(child, *part, best) for child, part in zip(children, parts)]
    refuse_unless(len(seen) == len(nodes), "a box is not a part of another")


def check_box(job):
    """Return the reason why the statements on a box do not follow, or None."""
    place, node, *box = job
    try:
        bound, _, slopes, undecided = PROOF.bound(*box, node["evidence"])
    except ArithmeticError as error:
        return f"nodes[{place}] cannot be bounded: {error}"
    if "bound" in node and not bound >= float.fromhex(node["bound"]):
        return f"nodes[{place}].bound is {float.fromhex(node['bound'])}, but only {bound} follows"
    for k, side in node.get("sides", []):
        if undecided or not (slopes.get(k, ZERO) * {"upper": -1, "lower": 1}[side] >= 0):
            return f"nodes[{place}].sides: the objective may be less elsewhere in the box"
    return None


def find_infinite(value, path=()):
    """Return the path of a number that is none, or is infinite and no bound or limit of roots; None
    without one.
    """
    if isinstance(value, dict | list):
        items = value.items() if isinstance(value, dict) else enumerate(value)
        places = (
            find_infinite(part, (*path, key)) for key, part in items if path or key not in TEXTS
        )
        return next((place for place in places if place), None)
    try:
        number = (
            float.fromhex(value)
            if isinstance(value, str)
            else value
            if isinstance(value, float)
            else 0.0
        )
    except ValueError:  # a name, or no number, which whoever reads it refuses
        return None
    except OverflowError:
        return path
    may_be_infinite = path[-1] in ("bound", "lower_bound") or (
        path[0] == "response" and "limits" in path
    )
    return None if math.isfinite(number) or (number == math.inf and may_be_infinite) else path


ARGUMENTS = {"arctan2": 2, "select": 3, "or": 2, "and": 2}
ARGUMENTS |= dict.fromkeys(("multiply", "add"), 2) | dict.fromkeys(("input", "constant", "pi"), 0)


def check_step(n, name, arguments, numbers, count):
    """Refuse an operation of a program with other arguments or numbers than it has; `count` is that
    of the inputs.
    """
    refuse_unless(name in OPERATIONS or name in FUNCTIONS, f"there is no such operation: {name}")
    are_earlier = all(is_whole(a, 0, n - 1) for a in arguments)
    values = [float.fromhex(x) for x in numbers]
    size = int(values[0]) if name == "solve" else 0
    expected = size * (size + 1) if name == "solve" else ARGUMENTS.get(name, 1)
    have_form = {
        "constant": lambda x: True,
        "input": lambda x: x in range(count),
        "power": lambda x: x in range(1, LARGEST_POWER + 1),
    }.get(name)
    if have_form:
        are_right = len(values) == 1 and have_form(values[0])
    elif name in ("below", "solve"):
        pairs = [(0, 1)] * 2 if name == "below" else [range(1, 1 + LARGEST_POWER), range(size)]
        are_right = len(values) == 2 and all(x in pair for x, pair in zip(values, pairs))
    else:
        are_right = bool(values) if name == "polynomial" else not values
    is_right = are_earlier and are_right and len(arguments) == expected
    refuse_unless(is_right, f"operation {n}, {name}, has other arguments or numbers than it takes")


def check_program(stage):
    """Refuse a program with an operation of a later result, with a condition for a number or the
    other way round, or with a choice that may jump and does not say so.
    """
    steps, results = stage["operations"], stage["outputs"]
    count = len(stage["inputs"]) + len(stage["limits"])
    for n, (name, arguments, numbers) in enumerate(steps):
        check_step(n, name, arguments, numbers, count)
    conditions = [name in (*LOGIC, "below") for name, *_ in steps]
    for name, arguments, _ in steps:
        kinds = [conditions[a] for a in arguments]
        right = [False, False, True] if name == "select" else [name in LOGIC] * len(kinds)
        reason = f"{name} takes a condition for a number, or a number for a condition"
        refuse_unless(kinds == right, reason)
    are_numbers = all(is_whole(k, 0, len(steps) - 1) and not conditions[k] for k in results)
    refuse_unless(are_numbers and results, "a result is no number")
    for n, (name, _, numbers) in enumerate(steps):
        jumps = name != "below" or float.fromhex(numbers[1])
        reason = f"operation {n}: what is chosen may jump where its condition changes"
        refuse_unless(jumps or is_continuous_choice(steps, n), reason)


def is_continuous_choice(steps, n):
    """Return whether all that a condition `below` chooses from is equal where it changes: x or -x
    where x is zero, a or b where a - b is.
    """

    def is_minus(k, m):
        return steps[k][0] == "negate" and steps[k][1] == [m]

    (argument,) = steps[n][1]
    parts = steps[argument][1] if steps[argument][0] == "add" else []
    zeros = [k for k in parts if steps[k] == ["constant", [], ["0x0.0p+0"]]]
    alone = [k for k in parts if k not in zeros] if zeros else [argument]
    for name, arguments, _ in steps:
        if n not in arguments:
            continue
        yes, no = arguments[:2]
        is_sign = is_minus(no, yes) and len(alone) == 1
        is_sign = is_sign and (alone[0] in (yes, no) or is_minus(alone[0], yes))
        pairs = [(yes, no), (no, yes)]
        is_difference = len(parts) == 2 and any(
            a in parts and any(is_minus(k, b) for k in parts) for a, b in pairs
        )
        if name != "select" or not (is_sign or is_difference):
            return False
    return True


def is_size(steps, k):
    """Return whether the form of a program shows that its result k is nowhere below zero."""

    def is_minus(m, n):
        return steps[m][0] == "negate" and steps[m][1] == [n]

    sure = []
    for name, a, numbers in steps[: k + 1]:
        sizes = [sure[n] for n in a]
        if name in ("constant", "power", "multiply", "select"):
            value = float.fromhex(numbers[0]) if numbers else 0.0
            holds = {
                "constant": value >= 0,
                "power": value % 2 == 0 or all(sizes),
                "multiply": all(sizes) or a[0] == a[-1],
                "select": all(sizes[:2]),
            }[name]
        else:
            holds = name in ("pi", "sqrt", "exp") or (name in ("add", "inverse") and all(sizes))
        if (
            name == "select" and is_minus(a[1], a[0]) and steps[a[2]][0] == "below"
        ):  # x where 0 - x <= 0, else -x
            name, parts, _ = steps[steps[a[2]][1][0]]
            zeros = [n for n in parts if steps[n] == ["constant", [], ["0x0.0p+0"]]]
            rest = (
                [n for n in parts if n not in zeros]
                if name == "add" and zeros
                else [steps[a[2]][1][0]]
            )
            holds |= len(rest) == 1 and is_minus(rest[0], a[0])
        sure.append(holds)
    return sure[k]


def compute_digest(document: Mapping) -> str:
    """Return the hash of all of a document but the hash itself."""
    content = {key: value for key, value in document.items() if key != "sha256"}
    text = json.dumps(content, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()


def is_whole(value, low, high=math.inf):
    """Return whether a value is a whole number within limits."""
    return isinstance(value, int) and not isinstance(value, bool) and low <= value <= high


def are_names(names):
    """Return whether names are different texts."""
    return all(isinstance(name, str) and name for name in names) and len(set(names)) == len(names)


def check_size(document):
    """Refuse a document that asks to compute more than any proof of planter's."""
    response, samples = document["response"], document["samples"]
    is_count = samples is None or is_whole(samples, 1, MOST_SAMPLES)
    refuse_unless(is_count, f"samples must be a whole number between 1 and {MOST_SAMPLES}")
    for text in (response["period"], *response["offsets"]):  # 1e99999999 would be written out
        is_fraction = len(text) <= LONGEST_FRACTION and re.fullmatch(r"-?\d+(/[1-9]\d*)?", text)
        refuse_unless(is_fraction, "a share of a revolution is no fraction, or has too many digits")
    for entry in (document["incumbent"], *document["nodes"]):
        evidence = entry.get("evidence", {})
        for parts in (evidence[key]["parts"] for key in ("panels", "narrow") if key in evidence):
            is_count = all(is_whole(n, 1) for n in parts) and sum(parts) <= MOST_PANELS
            reason = f"a box must have whole numbers of panels, {MOST_PANELS} at most"
            refuse_unless(is_count, reason)


def check_form(document: Mapping) -> None:
    """Refuse a document that is too large, whose hash is another, whose parts do not fit, or to
    whose measures the rules of bounds do not apply.
    """
    unlike = f"keys that no proof has, or that it lacks: {set(KINDS) ^ set(document)}"
    refuse_unless(set(document) == set(KINDS), unlike)
    refuse_unless(document["format"] == FORMAT, f"format must be {FORMAT!r}")
    for key, kind in KINDS.items():
        refuse_unless(isinstance(document[key], kind), f"{key} must be of the kind {kind}")
    check_size(document)  # first: the other checks take as long as what is asked for
    is_true = compute_digest(document) == document["sha256"]
    refuse_unless(is_true, "sha256 does not match the content of the file")
    infinite = find_infinite(document)
    refuse_unless(not infinite, f"{infinite} is not finite")
    hashes, response, box = document["generated"], document["response"], document["box"]
    digits = set("0123456789abcdef")
    stated = bool(hashes) and all(len(x) == 64 and digits.issuperset(x) for x in hashes.values())
    refuse_unless(
        stated, "generated must hold a SHA-256 of each module that the programs were recorded from"
    )
    names, count = document["parameters"], response["parameters"]
    sides = [names, document["scales"], *box, document["incumbent"]["x"]]
    is_fit = are_names(names) and [len(side) for side in sides] == [count] * 5
    refuse_unless(is_fit, "parameters must be different names, one for each side")
    are_scales = all(float.fromhex(scale) > 0 for scale in document["scales"])
    is_named = set(document["machine"]) == {"source", "model", "changes", "quantities", "inputs"}
    refuse_unless(are_scales and is_named, "machine and scales must say what is proved of what")
    for name, low, high in zip(names, *box):
        refuse_unless(float.fromhex(low) <= float.fromhex(high), f"the box is empty along {name}")
    refuse_unless(isinstance(response["continuous"], bool), "continuous must be true or false")
    kind = "sampled" if document["samples"] else "true"
    refuse_unless(document["kind"] == kind, "kind does not fit samples")
    refuse_unless(Fraction(response["period"]) > 0, "period must be positive")
    for entry in (document["incumbent"], *document["nodes"]):
        evidence = entry.get("evidence", {})
        parts = evidence, evidence.get("panels", {}), evidence.get("narrow", {})
        rows = [row for part in parts for row in part.get("rates", [])]
        reason = f"evidence must have a rate for each of {count} parameters"
        refuse_unless(all(len(row) == count for row in rows), reason)
    size = count + 1
    for stage in response["stages"]:
        check_program(stage)
        are_earlier = all(is_whole(k, 0, size - 1) for k in stage["inputs"])
        refuse_unless(are_earlier, "an input of a stage is none of the values before it")
        roots = len(stage["limits"])
        refuse_unless(not roots or len(stage["outputs"]) == roots, "roots need as many equations")
        size += len(stage["outputs"])
    refuse_unless(not response["stages"][-1]["limits"], "the last stage has roots")
    check_assembly(document)
    check_nodes(document)
    last, labels = response["stages"][-1], document["quantities"]
    is_fit = are_names(labels) and len(labels) == len(last["outputs"])
    refuse_unless(is_fit, "quantities must be different names of results")
    refuse_unless(document["terms"], "there must be a term")
    for entry in (*document["terms"], *document["limits"]):
        check_measure(entry, last)
    is_same = document["trusted"] == list_trusted(document)
    refuse_unless(is_same, "trusted does not follow from the file")
    is_same = document["statement"] == state_claim(document)
    refuse_unless(is_same, "statement does not follow from the file")


def check_assembly(document):
    """Refuse an assembly that does not fit the stages with roots."""
    assembly, stages = document["assembly"], document["response"]["stages"]
    sizes = [len(stage["limits"]) for stage in stages if stage["limits"]]
    refuse_unless((assembly is None) == (not sizes), "assembly must state which roots are meant")
    if assembly is None:
        return
    count = document["response"]["parameters"]
    is_fit = [len(roots) for roots in assembly["roots"]] == sizes
    is_fit &= len(assembly["design"]) == count and set(assembly) == {"design", "roots"}
    refuse_unless(is_fit, "assembly must have a design, and a number for each root of each stage")
    for values in (assembly["design"], *assembly["roots"]):
        refuse_unless(all(isinstance(x, str) for x in values), "assembly has a number of no kind")


def check_nodes(document):
    """Refuse boxes with keys, sides or evidence of other kinds than theirs."""
    count, length = document["response"]["parameters"], len(document["nodes"])
    evidence = {"continued"} if document["assembly"] else set()
    if document["samples"] is None:
        evidence |= {"panels", "narrow", "peaks", "rates"}
    for place, node in enumerate(document["nodes"]):
        keys = {"bound", "split", "sides", "next", "children", "evidence"}
        is_known = set(node) <= keys and set(node.get("evidence", ())) <= evidence
        refuse_unless(is_known, f"nodes[{place}] has a key that has no meaning there")
        ends = [*node.get("sides", []), *([node["split"]] if "split" in node else [])]
        are_pairs = all(len(pair) == 2 and is_whole(pair[0], 0, count - 1) for pair in ends)
        are_sides = all(side in ("lower", "upper") for _, side in node.get("sides", []))
        refuse_unless(are_pairs and are_sides, f"nodes[{place}] has a side that there is not")
        places = [*node.get("children", []), node.get("evidence", {}).get("continued", 0)]
        refuse_unless(all(is_whole(k, 0, length - 1) for k in places), "there is no such box")
    keys = set(document["incumbent"].get("evidence", ()))
    refuse_unless(keys <= evidence - {"continued"}, "the evidence of incumbent has no meaning")


def check_measure(entry, stage):
    """Refuse a measure of no result of a stage, or of a size or a sign that the rules of bounds do
    not cover.
    """
    kind, k, weight = entry["measure"], entry["quantity"], float.fromhex(entry["weight"])
    is_known = kind in MEASURES and (entry["angle_deg"] is not None) == (kind == "at")
    refuse_unless(is_known, f"there is no measure {kind} with such an angle")
    refuse_unless(is_whole(k, 0, len(stage["outputs"]) - 1), f"{kind} is of no result")
    refuse_unless(isinstance(entry["size"], bool), "size must be true or false")
    is_shown = not entry["size"] or is_size(stage["operations"], stage["outputs"][k])
    refuse_unless(is_shown, f"size: result {k} may be negative")
    if "limit" in entry:
        is_sign = entry["sign"] in (1, -1) and not isinstance(entry["sign"], bool)
        refuse_unless(weight == 1 and is_sign, "a limit has the weight 1 and a sign")
    elif kind in SIDES:
        reason = (
            f"the weight {weight} of {kind} has a sign that the rule of extremes does not cover"
        )
        refuse_unless(weight <= 0 if kind == "min" else weight >= 0, reason)


def write_number(text):
    """Return a number with all of its digits."""
    return repr(float.fromhex(text))


def name_measure(document, entry):
    """Return in words what a measure is of."""
    name = document["quantities"][entry["quantity"]]
    if entry["angle_deg"] is not None:
        return f"value of {name} at {write_number(entry['angle_deg'])} deg"
    return f"{entry['measure']} of {name}"


def list_ineffective(document):
    """Return the parameters that no result depends on, as the programs show: they take none of
    them.
    """
    response = document["response"]
    count = response["parameters"]
    needed = [{k} for k in range(count)] + [set()]
    for stage in response["stages"]:
        size, rests = len(stage["limits"]), []
        parts = [set()] * size + [needed[k] for k in stage["inputs"]]
        for name, arguments, numbers in stage["operations"]:
            taken = parts[int(float.fromhex(numbers[0]))] if name == "input" else set()
            rests.append(taken.union(*(rests[a] for a in arguments)))
        results = [rests[k] for k in stage["outputs"]]
        needed += [set().union(*results)] * size if size else results
    used = set().union(*needed[len(needed) - len(response["stages"][-1]["outputs"]) :])
    return [name for k, name in enumerate(document["parameters"]) if k not in used]


def list_trusted(document: Mapping) -> list:
    """Return, in words, all that is taken as stated; everything else is computed again."""
    response, assembly, machine = document["response"], document["assembly"], document["machine"]
    over = (
        "the whole cycle"
        if document["samples"] is None
        else f"{document['samples']} samples of the cycle"
    )
    signs = {1: "<=", -1: ">="}
    total = " + ".join(
        f"{write_number(term['weight'])} {name_measure(document, term)}"
        for term in document["terms"]
    )
    limits = " and ".join(
        f"{name_measure(document, x)} {signs[x['sign']]} {write_number(x['limit'])}"
        for x in document["limits"]
    )
    changes = ", ".join(f"{key} = {x!r}" for key, x in machine["changes"].items())
    ends = zip(document["parameters"], document["scales"], *document["box"])
    sides = ", ".join(describe_side(*side) for side in ends)
    model = f", {machine['model']} model" if machine["model"] else ""
    programs = f"programs: response has the results of {machine['source']}{model}"
    trusted = [
        programs + (f", with {changes}" if changes else ""),
        f"sum: {total}, over {over}",
        f"limits: {limits or 'none'}{'' if document['all_limits'] else ', and others not heeded'}",
        f"box: {sides}",
        f"cycle: results repeat after {response['period']} turns, and are sums of sides at "
        + " and ".join(f"{offset} turns" for offset in response["offsets"]),
        "jumps: where a condition changes its answer, results "
        + ("do not jump" if response["continuous"] else "may jump"),
    ]
    if assembly is not None:
        design = ", ".join(
            f"{name} = {write_number(x)}"
            for name, x in zip(document["parameters"], assembly["design"])
        )
        roots = ", ".join(write_number(x) for part in assembly["roots"] for x in part)
        trusted.append(
            f"assembly: roots are those near {roots} at the angle 0 and the design {design} in SI "
            f"units, followed straight to other designs and from there along the cycle; designs "
            f"that they cannot be followed to do not count"
        )
    return trusted


def describe_side(name, scale, low, high):
    """Return in words between what a parameter is, in the unit of its name and in SI."""
    low, high, scale = map(float.fromhex, (low, high, scale))
    if low == high:
        return f"{name} = {low / scale:.12g} ({low!r} in SI)"
    return f"{name} from {low / scale:.12g} to {high / scale:.12g} ({low!r} to {high!r} in SI)"


def state_claim(document: Mapping) -> str:
    """Return what is proved, in words: numbers with all digits."""
    entry, bound = document["incumbent"], document["lower_bound"]
    design = ", ".join(
        f"{name} = {write_number(x)}" for name, x in zip(document["parameters"], entry["x"])
    )
    claim = (
        "nothing bounds it from below"
        if bound is None
        else f"no design is below {write_number(bound)}"
    )
    reached = entry["upper_bound"]
    incumbent = (
        "no design was enclosed"
        if reached is None
        else f"the design {design} is at most {write_number(reached)}"
    )
    gap = ""
    if bound is not None and reached is not None:
        gap = f", so that the gap is {float.fromhex(reached) - float.fromhex(bound):.3g}"
    without = list_ineffective(document)
    names = (
        f" Without any effect, as no result takes them: {', '.join(without)}." if without else ""
    )
    machine, *trusted = (entry.partition(": ")[2] for entry in document["trusted"][:4])
    scope = f"{machine.removeprefix('response has the results of ')}: of {trusted[0]}"
    return f"{scope}, for {trusted[2]}, limits: {trusted[1]}: {claim}; {incumbent}{gap}.{names}"


def check_in_processes(path, processes, jobs):
    """Yield the reasons of boxes, found by several processes."""
    with ProcessPoolExecutor(processes, initializer=load_proof, initargs=[path]) as pool:
        yield from pool.map(check_box, jobs)


def check_claims(document, check_boxes):
    """Raise ValueError unless all that a document states follows."""
    check_period(document)
    boxes, stated, entry = (
        list(list_boxes(document)),
        document["lower_bound"],
        document["incumbent"],
    )
    lowest = min(best for _, node, *_, best in boxes if not node.get("children"))
    if entry["upper_bound"] is not None:
        x, reached = list(map(float.fromhex, entry["x"])), float.fromhex(entry["upper_bound"])
        is_inside = all(
            low <= value <= high for low, value, high in zip(boxes[0][2], x, boxes[0][3])
        )
        refuse_unless(is_inside, "incumbent.x is outside of the box")
        refuse_unless(
            PROOF.bound(x, x, (x, x), entry["evidence"])[1] <= reached,
            "incumbent.upper_bound is below what follows",
        )
        lowest = min(lowest, reached)
    refuse_unless(
        stated is None or float.fromhex(stated) <= lowest, "lower_bound is above the bound of a box"
    )
    jobs = [box[:5] for box in boxes if "evidence" in box[1]]
    for number, reason in enumerate(check_boxes(jobs), 1):
        print(f"\r{number} of {len(jobs)} boxes", end="\n" * (number == len(jobs)), file=sys.stderr)
        refuse_unless(not reason, reason)


def check_period(document):
    """Refuse a period after which the quantities of the incumbent are certainly others."""
    x, response = [float.fromhex(x) for x in document["incumbent"]["x"]], PROOF.response
    branch, space = PROOF.find_branch(x, x), BoxSpace(x, x, 0)
    fixed = response.advance(space, space.parameters(), branch)
    for number in range(1, 1 + TRIALS):
        turn = Fraction(number * 21, 34) % 1 * response.period  # spread evenly
        angles = [space.constant(turn_angle(way)) for way in (turn, turn + response.period)]
        sides = [response.enclose(space, fixed, branch, [], phi) for phi in angles]
        is_same = None in sides or all(a.c.overlaps(b.c) for a, b in zip(*sides))
        reason = "period: after it, the quantities of incumbent.x are others"
        refuse_unless(is_same, reason)


def list_random_points(document):
    """Yield designs of the box, and angles [rad]; the numbers are the same in each run."""
    numbers = random.Random(document["sha256"])
    sides = [list(map(float.fromhex, side)) for side in document["box"]]
    for _ in range(TRIALS):
        yield [numbers.uniform(*pair) for pair in zip(*sides)], numbers.uniform(0, 2 * math.pi)


def evaluate_response(document, x, phi):
    """Return the roots of all stages, and the quantities at an angle, in plain numbers."""
    response, assembly = PROOF.response, document["assembly"]
    roots, number = [], 0
    if assembly:
        origin = [float.fromhex(value) for value in assembly["design"]]
        starts = [[float.fromhex(value) for value in part] for part in assembly["roots"]]
        steps = math.ceil(abs(phi) / math.radians(5)) + 1
        _, points = list_cells(origin, x, x, phi, steps)
        roots = follow_plainly(response.plain, starts, points)[-1]
        if roots is None:
            raise ArithmeticError("loops are not closed")
    values = dict(enumerate([*x, phi]))
    for program, inputs, _, places in response.stages:
        arguments = [values[k] for k in inputs]
        if program.size:
            results, number = roots[number], number + 1
        else:
            results = evaluate_plainly(program.steps, program.outputs, arguments)
        values.update(zip(places, results))
    return roots, [values[k] for k in places]


def load_module(path):
    """Return a Python file as a module, and its text."""
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module, path.read_text(encoding="utf-8")


def find_result(text, name):
    """Return the place of a result by its name among those of the function `lane`."""
    functions = [node for node in ast.parse(text).body if isinstance(node, ast.FunctionDef)]
    lane = next(node for node in functions if node.name == "lane")
    return [ast.unparse(entry) for entry in lane.body[-1].value.elts].index(name)


def fill_data(document, x):
    """Return all values that a mechanism's own functions take, for a design."""
    inputs = document["machine"]["inputs"]
    data = [float.fromhex(value) for value in inputs["data"]]
    for index, value in zip(inputs["moved"], x):
        data[index] = value
    return data


def compare_assembly(xp, module, document):
    """Refuse an assembly to which Newton's method does not lead from a mechanism's own start."""
    x, roots = document["assembly"]["design"], document["assembly"]["roots"][0]
    x, roots = ([float.fromhex(value) for value in values] for values in (x, roots))
    start = list(map(float, module.assembly(xp, fill_data(document, x))))
    steps, outputs, inputs, *_ = next(stage for stage in PROOF.response.plain if stage[-1])
    values = [*x, 0.0]
    nearest = find_plainly(steps, outputs, start, [values[k] for k in inputs])
    gaps = [abs(a - b) for a, b in zip(nearest, roots)]
    is_same = all(
        min(gap, abs(gap - 2 * math.pi * round(gap / 2 / math.pi))) < MEANT for gap in gaps
    )
    refuse_unless(is_same, "--machine: its cycle begins in another assembly")


def call_mechanism(xp, module, text, document, x, phi, roots):
    """Return the results of a mechanism's own functions at an angle, and the gaps of its loops."""
    data = fill_data(document, x)
    pairs = {"data": data, "loops": roots[0] if roots else []}
    gaps = module.closure(xp, phi, data, roots[0])[: len(roots[0])] if roots else []
    if hasattr(module, "prologue"):
        names = inspect.signature(module.prologue).parameters
        pairs["hoisted"] = module.prologue(*(pairs.get(name, xp) for name in names))
    names = list(inspect.signature(module.lane).parameters)[2:]
    rows = module.lane(xp, phi, *(pairs[name] for name in names))
    entries = document["machine"]["quantities"]
    return [rows[find_result(text, entry["name"])] for entry in entries], gaps


def call_device(xp, module, path, document, x, phi):
    """Return the force of a planting device by its own functions and those of its curves."""
    inputs, arguments, contacts = document["machine"]["inputs"], [], []
    constants = [float.fromhex(value) for value in inputs["machine"]]
    first = inputs["mounting"]
    for name, count, terms in inputs["stages"]:
        curve, _ = load_module(path.with_name(f"{name}.py"))
        parameters = x[first : first + count]
        arguments += [parameters, curve.prologue(xp, parameters, terms)]
        contacts.append(curve.contact)
        first += count
    fixed = [x[: inputs["mounting"]], *arguments, constants]
    still = module.prologue(xp, *fixed, *contacts)
    return module.lane(xp, phi, *fixed, still, *contacts)


def compare_module(document, path):
    """Refuse programs that differ from the functions over arrays of a generated module at random
    points of the box; return what was compared, in words.
    """
    xp, (module, text) = importlib.import_module("numpy"), load_module(path)
    digest, compared = hashlib.sha256(text.encode()).hexdigest(), 0
    remark = "" if digest in document["generated"].values() else ", which has another hash"
    if document["assembly"] and "data" in document["machine"]["inputs"]:
        compare_assembly(xp, module, document)
    gaps, rows = [], []
    for x, phi in list_random_points(document):
        try:
            roots, ours = evaluate_response(document, x, phi)
        except (ArithmeticError, ValueError):
            continue
        if "data" in document["machine"]["inputs"]:
            theirs, closed = call_mechanism(xp, module, text, document, x, phi, roots)
            gaps += map(float, closed)
        else:
            theirs = call_device(xp, module, path, document, x, phi)
        pairs = zip(document["machine"]["quantities"], ours, theirs)
        for entry, value, other in pairs:
            if not entry["is_work"]:  # whose factor is the length of a cycle
                other = abs(other) if entry["size"] else other
                rows.append((value, float(other) / float.fromhex(entry["factor"])))
        compared += 1
    largest = max((abs(other) for _, other in rows), default=0.0)
    is_same = all(abs(a - b) <= SAME * largest for a, b in rows)
    refuse_unless(rows and is_same, f"--machine: the programs are not those of {path}")
    refuse_unless(all(abs(gap) <= SAME for gap in gaps), f"--machine: {path} has other loops")
    return f"Compared with {path}{remark}, at {compared} random points of the box."


def read_file(path):
    """Return the content of a file."""
    with open(path, encoding="utf-8") as file:
        return json.load(file)


def load_proof(path):
    """Read a file, in every process."""
    global PROOF
    ctx.prec = 64
    document = read_file(path)
    check_form(document)
    PROOF = ProofClaims(document)
    return document


def read_options():
    """Return the options of the command line."""
    parser = argparse.ArgumentParser(description="Check a proof of planter without planter.")
    parser.add_argument("file", help="proof.json")
    parser.add_argument("processes", type=int, nargs="?", help="number of processes")
    parser.add_argument(
        "--machine", type=Path, help="array/NAME.py of the generated code, to compare with"
    )
    return parser.parse_args()


def explain_proof(document, compared):
    """Return in words what was proved, what was trusted, and what was not compared."""
    modules = ", ".join(document["generated"])
    missing = f"whether the programs are those of a machine (the generated code {modules})"
    rest = "whether other designs and angles agree" if compared else missing
    trusted = "\n".join(f"  {entry}" for entry in document["trusted"])
    lines = [document["statement"], "Trusted as the file states it:", trusted, compared]
    return "\n".join([*filter(None, lines), f"Not compared: {rest}."])


def main():
    """Check the proof of the command line; return the exit code."""
    options = read_options()
    try:
        document = read_file(options.file)
    except Exception as error:
        print(f"not readable: {type(error).__name__}: {error}")
        return 2
    try:
        load_proof(options.file)
        check_claims(
            document, functools.partial(check_in_processes, options.file, options.processes)
        )
        compared = options.machine and compare_module(document, options.machine)
        print(explain_proof(document, compared))
    except (ValueError, NoBound) as error:
        print(error)
        return 1
    except Exception as error:
        print(f"{type(error).__name__}: {error}")
        return 1
    print("valid")
    return 0


if __name__ == "__main__":
    sys.exit(main())
