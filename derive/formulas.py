"""A machine of equations, where there are no bodies: what holds of its quantities, and functions in
closed form.

>>> from derive.quantity import quantities
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
from .equations import (
    Claimed,
    ClaimError,
    Equation,
    Relation,
    by_claim,
    derived_equation,
    find_claim,
    what,
)
from .evaluate import DIGITS, GUARD
from .model import MESHES, PLACES, ClosedForm, Lane, Let, Mesh, System, build_function, sorted_steps
from .quantity import NOTHING, Quantities, Quantity, Vector

Wanted = Let | Claimed | tuple[Claimed, Quantity]
"""A step, a definition by what it claims to be, or any equation by its claim with what it is solved
for.
"""
Values = dict[Quantity, mpf]


class Formulas:
    """Equations by what they claim to be, and the functions in closed form that solve them.

    ``given`` is the table of quantities, all in SI. With ``angle`` [rad] and ``speed`` [rad/s] of
    the table, an angle drives them as it drives a mechanism, and the commands for mechanisms work
    on them. ``bind`` replaces symbols of the equations by expressions; ``lacking`` lists claims
    that the source does not make: steps that need them are left out. ``told`` is the pattern of the
    names of packed outputs. Raises ClaimError if a claim is made twice, or made and lacking;
    ValueError for an angle without a speed or in other units.

    >>> from derive import Formulas, quantities, what
    >>> q = quantities('''
    ...     t | rad   | driver
    ...     n | rad/s | speed of the driver | 9
    ...     r | m     | crank               | 0.02
    ...     y | m     | height
    ... ''')
    >>> f = Formulas("crank", given=q, angle=q.t, speed=q.n)
    >>> from sympy import sin
    >>> f.defines(q.y, q.r * sin(q.t))
    y
    >>> f.expr(what(q.y))
    r*sin(t)
    >>> f.function("height", (q.t, q.r), what(q.y)).outputs.quantities
    (y,)
    >>> f.system().lane.outputs.quantities
    (y,)
    """

    def __init__(
        self,
        name: str,
        equations: Iterable[Equation] = (),
        *,
        given: Quantities = NOTHING,
        title: str = "",
        source: str = "own",
        assumptions: Iterable[str] = (),
        told: str = "{}_outputs",
        bind: Mapping[sp.Symbol, Expr] | None = None,
        lacking: frozenset[Claimed] = frozenset(),
        angle: Quantity | None = None,
        speed: Quantity | None = None,
    ) -> None:
        if (angle and angle.unit, speed and speed.unit) not in ((None, None), ("rad", "rad/s")):
            raise ValueError(
                f"{name}: formulas are driven by an angle in rad at a speed in rad/s, or not at all"
            )
        self.angle, self.speed = angle, speed
        self.name, self.title, self.source = (
            name,
            title or name.replace("_", " ").capitalize(),
            source,
        )
        self.assumptions, self.given = tuple(assumptions), given
        self.equations, self.bind, self.lacking = by_claim(equations), dict(bind or {}), lacking
        self.told, self.functions, self.meshes = told, list[ClosedForm](), list[Mesh]()
        if contradictions := sorted(map(str, lacking & self.equations.keys())):
            raise ClaimError(
                f"said to be lacking, but stated: {', '.join(map(repr, contradictions))}"
            )

    def defines(
        self,
        symbol: Quantity,
        expr: Expr,
        claim: Claimed | None = None,
        *,
        named: bool = False,
        where: sp.Basic = sp.true,
    ) -> Quantity:
        """State that ``symbol`` equals ``expr``, in the unit of the symbol, and return the symbol.

        The claim is ``what(symbol)`` unless another is passed. ``named`` says that the equation
        holds by the meaning of the symbol, so that nothing is derived; ``where`` is a condition
        under which it holds. Raises ClaimError if the claim is made twice. Example: `Formulas`.
        """
        self.holds(claim or what(symbol), symbol - expr, defines=symbol, named=named, where=where)
        return symbol

    def holds(
        self,
        claim: Claimed,
        residual: Expr,
        relation: Relation = "=",
        *,
        defines: Quantity | None = None,
        named: bool = False,
        where: sp.Basic = sp.true,
    ) -> None:
        r"""State that ``residual``, in any one unit, is zero, or less or greater than zero by
        ``relation``.

        ``claim`` says what the equation is, ``defines`` the symbol that it may be solved for.
        ``named`` and ``where`` are as in `defines`. Raises ClaimError if the claim is made twice.

        >>> from derive import Formulas, quantities, what
        >>> q = quantities("r | m | radius | 0.02\nR | m | the other | 0.04\na | m | distance")
        >>> f = Formulas("gears", given=q)
        >>> f.holds(what(q.a), q.r + q.R - q.a, defines=q.a)
        >>> f.expr(what(q.a))
        R + r
        """
        self._add(
            replace(derived_equation(claim, residual, defines, relation), stated=named, where=where)
        )

    def expr(self, claim: Claimed) -> Expr:
        """Return the expression that a definition gives for its symbol, in the unit of the symbol.

        Raises ClaimError if nothing is defined by that claim. Example: `Formulas`.
        """
        return self._defined(claim)[1]

    def steps(self, *order: Wanted) -> tuple[Let, ...]:
        r"""Return steps ``symbol = expr``, each in the unit of its symbol, that solve equations one
        after the other.

        Each of ``order`` is a step, the claim of a definition, or a claim with the symbol to solve
        it for. What depends on claims that the source lacks is left out. Raises ClaimError for a
        claim that nothing makes, ChainError for an equation that is not linear in its unknown.

        >>> from derive import Formulas, quantities, what
        >>> q = quantities("r | m | radius | 0.02\nR | m | the other | 0.04\na | m | distance")
        >>> f = Formulas("gears", given=q)
        >>> f.defines(q.a, q.r + q.R)
        a
        >>> [(step.symbol, step.expr) for step in f.steps((what(q.a), q.R))]
        [(R, a - r)]
        """
        missing: set[Quantity] = set()
        lets: list[Let] = []
        for request in order:
            if isinstance(request, Let):
                lets.append(request)
                continue
            claim, unknown = (
                request if isinstance(request, tuple) else (request, self._defined(request)[0])
            )
            step = None if claim in self.lacking else self._let(claim, unknown)
            if step is None or step.needs & missing:
                missing.add(unknown)
            else:
                lets.append(step)
        return tuple(lets)

    def function(
        self,
        name: str,
        inputs: Iterable[Vector | Quantity],
        *order: Wanted,
        gives: Iterable[Quantity] = (),
        told: str = "",
    ) -> ClosedForm:
        """Return a function in closed form of packed or single ``inputs``, in SI, which becomes
        part of the model.

        ``order`` is as in `steps`; ``gives`` selects the outputs, else all steps are; ``told``
        names the packed output. Raises ValueError if a step needs a quantity that neither an input
        nor a step gives. Example: `Formulas`.
        """
        steps = self.steps(*order)
        outputs = Vector(
            told or self.told.format(name), tuple(gives) or tuple(step.symbol for step in steps)
        )
        self.functions.append(ClosedForm(name, tuple(inputs), steps, outputs))
        return self.functions[-1]

    def followed(self, known: Mapping[Quantity, Any], *also: tuple[Claimed, Quantity]) -> Values:
        r"""Return the known values, in SI, with those that the definitions give from them, and the
        equations ``also``.

        A quantity takes its value from the first definition whose symbols are known.

        >>> from derive import Formulas, quantities
        >>> q = quantities("r | m | radius\nd | m | diameter")
        >>> f = Formulas("disc", given=q)
        >>> f.defines(q.d, 2 * q.r)
        d
        >>> f.followed({q.r: 3})[q.d]
        mpf('6.0')
        """
        formulas = [_solved(equation) for equation in self._definitions.values()]
        formulas += [(step.symbol, step.expr) for step in self.steps(*also)]
        values, before = dict(known), 0
        with mpmath.workdps(max(mpmath.mp.dps, DIGITS + GUARD)):
            while len(values) > before:
                before = len(values)
                for symbol, expr in formulas:
                    if symbol not in values and values.keys() >= expr.free_symbols:
                        values[symbol] = evaluate_expression(expr, values)
        return values

    def mesh(self, tag: str, inner: tuple[str, Expr, Expr], outer: tuple[str, Expr, Expr]) -> None:
        """State two gears that mesh side by side, each by name, angle and radius; the second is
        along x from the first.

        The angle [rad] is the direction of the pitch point in the gear's own frame,
        counter-clockwise, so that the two run against each other; the radius [m] is that of the
        pitch curve there. Both are expressions of the driving angle. Raises ClaimError if no angle
        drives the formulas.

        >>> from derive import Formulas, quantities
        >>> q = quantities('''
        ...     t | rad   | driver
        ...     n | rad/s | speed of the driver | 9
        ...     r | m     | both gears          | 0.02
        ... ''')
        >>> f = Formulas("equal_gears", given=q, angle=q.t, speed=q.n)
        >>> f.mesh("P", ("driver", -q.t, q.r), ("mate", q.t, q.r))
        >>> dict(f.system().meshes)
        {'P': ('driver', 'mate')}
        """
        if self.angle is None:
            raise ClaimError(
                f"{self.name}: gears mesh along an angle, but none drives these formulas"
            )
        gears, polar, radii = zip(inner, outer, strict=True)
        self.meshes.append(Mesh(tag, gears, sp.S.Zero, (sp.Add(*radii), sp.S.Zero), polar, radii))

    def system(self) -> System:
        """Return the model, in SI: all functions, and along the angle, if there is one, everything
        that is defined.

        Raises ValueError if definitions need each other in a circle, or a quantity that nothing
        gives; ChainError if one cannot be solved for its symbol. Example: `Formulas`.
        """
        if self.angle is None:
            return System(
                self.name,
                self.title,
                self.source,
                self.assumptions,
                closed_forms=tuple(self.functions),
            )
        lets = [self._let(claim, self._defined(claim)[0]) for claim in self._definitions]
        steps = sorted_steps(lets)
        data_by_name = {
            name: datum for name, datum in self.given.data.items() if self.given[name] != self.angle
        }
        data = Vector("data", tuple(self.given[name] for name in data_by_name))
        points = [step for mesh in self.meshes for step in mesh.places()]
        mesh_steps = [step for mesh in self.meshes for step in mesh.lets()]
        return System(
            self.name,
            self.title,
            self.source,
            self.assumptions,
            Lane(
                self.angle,
                (data,),
                steps,
                Vector("outputs", tuple(step.symbol for step in lets)),
                speed=self.speed,
            ),
            (
                *self.functions,
                *build_function(PLACES, points, (self.angle, data), steps),
                *build_function(MESHES, mesh_steps, (self.angle, data), steps),
            ),
            data_by_name,
            meshes={mesh.tag: mesh.gears for mesh in self.meshes},
        )

    @property
    def _definitions(self) -> dict[Claimed, Equation]:
        return {
            claim: equation
            for claim, equation in self.equations.items()
            if equation.defines is not None
        }

    def _add(self, equation: Equation) -> None:
        self.equations = by_claim((*self.equations.values(), equation))

    def _let(self, claim: Claimed, unknown: Quantity) -> Let:
        (step,) = Chain.of_claims(self.equations, [(claim, unknown)], self.bind).lets()
        return step

    def _defined(self, claim: Claimed) -> tuple[Quantity, Expr]:
        return _solved(find_claim(self._definitions, claim))


def evaluate_expression(expr: Expr, values: Mapping[Quantity, mpf]) -> mpf:
    """An expression at known values, to the precision of the moment."""
    symbols, function = _function(expr)
    return mpf(function(*(values[s] for s in symbols)))


@cache
def _function(expr: Expr) -> tuple[tuple[Quantity, ...], Callable[..., Any]]:
    symbols = tuple(sorted(expr.free_symbols, key=str))
    return symbols, sp.lambdify(symbols, expr, "mpmath")


@cache
def _solved(equation: Equation) -> tuple[Quantity, Expr]:
    """Return the symbol that a definition defines, and its expression."""
    assert equation.defines is not None
    return equation.defines, solve_linear(equation, equation.defines)
