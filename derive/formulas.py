"""A machine of equations, where there are no bodies: what holds of its quantities, and functions in closed form.

>>> from derive.table import quantities
>>> q = quantities('''
...     r | mm | radius       | 20 | 10 30
...     A | m2 | area of it
... ''')
>>> f = Formulas("disc", given=q)
>>> f.defines(q.A, 3 * q.r**2)
A
>>> f.function("area", (q.r,), what(q.A)).outputs.quantities
(A,)
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from functools import cache
from typing import Any

import mpmath
import sympy as sp
from mpmath import mpf
from sympy import Expr

from .chain import Chain, solve_linear
from .equations import Claim, Claimed, ClaimError, Equation, Relation, among, by_claim, derived, what
from .evaluate import DIGITS, GUARD
from .meshes import MESHES, PLACES, Mesh, build_function
from .model import ClosedForm, Lane, Let, System, sorted_steps
from .quantity import Quantity, Vector
from .table import NOTHING, Quantities

Wanted = Let | Claimed | tuple[Claimed, Quantity]
"""A step, a definition by what it claims to be, or any equation by its claim with what it is solved for."""
Values = dict[Quantity, mpf]


class Formulas:
    """Equations by what they claim to be, and the functions that solve them.

    ``told`` names a function's packed output by the function. ``bind`` says how a source means its symbols, ``lacking``
    lists claims that it does not make: what hangs on them, its functions do not give. With ``angle`` [rad] and
    ``speed`` [rad/s], of the table, an angle drives them as it drives a mechanism: whatever works on a machine works
    on what they define along it. Raises ClaimError if it makes a claim that it lacks, or makes one twice, ValueError
    for an angle without a speed or in other units.
    """

    def __init__(
        self, name: str, equations: Iterable[Equation] = (), *, given: Quantities = NOTHING, title: str = "",
        source: str = "own", assumptions: Iterable[str] = (), told: str = "{}_outputs",
        bind: Mapping[sp.Symbol, Expr] | None = None, lacking: frozenset[Claim] = frozenset(),
        angle: Quantity | None = None, speed: Quantity | None = None,
    ) -> None:  # fmt: skip
        if (angle and angle.unit, speed and speed.unit) not in ((None, None), ("rad", "rad/s")):
            raise ValueError(f"{name}: formulas are driven by an angle in rad at a speed in rad/s, or not at all")
        self.angle, self.speed = angle, speed
        self.name, self.title, self.source = name, title or name.replace("_", " ").capitalize(), source
        self.assumptions, self.given = tuple(assumptions), given
        self.equations, self.bind, self.lacking = by_claim(equations), dict(bind or {}), lacking
        self.told, self.functions, self.meshes = told, list[ClosedForm](), list[Mesh]()
        if made := sorted(map(str, lacking & self.equations.keys())):
            raise ClaimError(f"said to be lacking, but stated: {', '.join(map(repr, made))}")

    def defines(
        self, symbol: Quantity, expr: Expr, claim: Claimed | None = None, *, named: bool = False,
        where: sp.Basic = sp.true,
    ) -> Quantity:  # fmt: skip
        """State what a symbol comes out to be, or is by its meaning, ``named``, on the condition ``where``.

        The claim is ``what(symbol)`` unless another is given.
        """
        self.holds(claim or what(symbol), symbol - expr, defines=symbol, named=named, where=where)
        return symbol

    def holds(
        self, claim: Claimed, residual: Expr, relation: Relation = "=", *, defines: Quantity | None = None,
        named: bool = False, where: sp.Basic = sp.true,
    ) -> None:  # fmt: skip
        """State what an expression is to zero; by its meaning, ``named``; on the condition ``where``."""
        self._add(replace(derived(claim, residual, defines, relation), stated=named, where=where))

    def expr(self, claim: Claimed) -> Expr:
        """What a definition says that its symbol is. Raises ClaimError where nothing is defined by that claim."""
        return self._defined(claim)[1]

    def steps(self, *order: Wanted) -> tuple[Let, ...]:
        """Equations solved one after the other, but for what hangs on claims that the source lacks.

        Raises ClaimError for a claim that nothing makes, ChainError for an equation that is not linear in its unknown.
        """
        missing: set[Quantity] = set()
        found: list[Let] = []
        for wanted in order:
            if isinstance(wanted, Let):
                found.append(wanted)
                continue
            claim, unknown = wanted if isinstance(wanted, tuple) else (wanted, self._defined(wanted)[0])
            step = None if claim in self.lacking else self._let(claim, unknown)
            if step is None or step.needs & missing:
                missing.add(unknown)
            else:
                found.append(step)
        return tuple(found)

    def function(
        self, name: str, inputs: Iterable[Vector | Quantity], *order: Wanted, gives: Iterable[Quantity] = (),
        told: str = "",
    ) -> ClosedForm:  # fmt: skip
        """A function in closed form: what its steps give, all of it unless told."""
        steps = self.steps(*order)
        outputs = Vector(told or self.told.format(name), tuple(gives) or tuple(step.symbol for step in steps))
        self.functions.append(ClosedForm(name, tuple(inputs), steps, outputs))
        return self.functions[-1]

    def followed(self, known: Mapping[Quantity, Any], *also: tuple[Claimed, Quantity]) -> Values:
        """Known values, and those of all that definitions, and some equations ``also``, make of them.

        Each quantity has its value by the first of them whose symbols are known.
        """
        formulas = [_solved(equation) for equation in self._definitions.values()]
        formulas += [(step.symbol, step.expr) for step in self.steps(*also)]
        found, before = dict(known), 0
        with mpmath.workdps(max(mpmath.mp.dps, DIGITS + GUARD)):
            while len(found) > before:
                before = len(found)
                for symbol, expr in formulas:
                    if symbol not in found and found.keys() >= expr.free_symbols:
                        found[symbol] = value(expr, found)
        return found

    def mesh(self, tag: str, inner: tuple[str, Expr, Expr], outer: tuple[str, Expr, Expr]) -> None:
        """State two gears that mesh along x: name, polar angle of the pitch point [rad] and pitch radius [m] of each.

        The angles are those in the gears' own frames, so that they run against each other. Raises ClaimError where no
        angle drives the formulas.
        """
        if self.angle is None:
            raise ClaimError(f"{self.name}: gears mesh along an angle, but none drives these formulas")
        gears, polar, radii = zip(inner, outer, strict=True)
        self.meshes.append(Mesh(tag, gears, sp.S.Zero, (sp.Add(*radii), sp.S.Zero), polar, radii))

    def system(self) -> System:
        """The model: all functions that were stated, and what is defined along the angle, if one drives them."""
        if self.angle is None:
            return System(self.name, self.title, self.source, self.assumptions, closed_forms=tuple(self.functions))
        lets = [self._let(claim, self._defined(claim)[0]) for claim in self._definitions]
        steps = sorted_steps(lets)
        given = {name: datum for name, datum in self.given.data.items() if self.given[name] != self.angle}
        data = Vector("data", tuple(self.given[name] for name in given))
        drawn = [step for mesh in self.meshes for step in mesh.places()]
        cut = [step for mesh in self.meshes for step in mesh.lets()]
        return System(
            self.name, self.title, self.source, self.assumptions,
            Lane(self.angle, (data,), steps, Vector("outputs", tuple(step.symbol for step in lets)), speed=self.speed),
            (
                *self.functions,
                *build_function(PLACES, drawn, (self.angle, data), steps),
                *build_function(MESHES, cut, (self.angle, data), steps),
            ),
            given, meshes={mesh.tag: mesh.gears for mesh in self.meshes},
        )  # fmt: skip

    @property
    def _definitions(self) -> dict[Claimed, Equation]:
        return {claim: equation for claim, equation in self.equations.items() if equation.defines is not None}

    def _add(self, equation: Equation) -> None:
        self.equations = by_claim((*self.equations.values(), equation))

    def _let(self, claim: Claimed, unknown: Quantity) -> Let:
        (step,) = Chain.of_claims(self.equations, [(claim, unknown)], self.bind).lets()
        return step

    def _defined(self, claim: Claimed) -> tuple[Quantity, Expr]:
        return _solved(among(self._definitions, claim))


def value(expr: Expr, known: Mapping[Quantity, mpf]) -> mpf:
    """An expression at known values, to the precision of the moment."""
    symbols, function = _function(expr)
    return mpf(function(*(known[s] for s in symbols)))


@cache
def _function(expr: Expr) -> tuple[tuple[Quantity, ...], Callable[..., Any]]:
    symbols = tuple(sorted(expr.free_symbols, key=str))
    return symbols, sp.lambdify(symbols, expr, "mpmath")


@cache
def _solved(equation: Equation) -> tuple[Quantity, Expr]:
    """What a definition defines, and what it says of it."""
    assert equation.defines is not None
    return equation.defines, solve_linear(equation, equation.defines)
