"""Motion of a mechanism as named steps: coordinates with rates, positions, accelerations, gear
stages, followers.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import sympy as sp
from sympy import Expr, S

from ..functions import clip, clip_slope
from ..model import Call, Event, Let, RuntimeFunction
from ..quantity import OpenVector, Quantity
from .frames import Frame, Point, Vec, displacement, shorten_vector
from .loops import Coordinate
from .statement import MechanismError, Statement, quantity

Slopes = dict[Quantity, Expr]


@dataclass
class Followed:
    """Steps in their order with their derivatives along coordinates; what depends on no coordinate
    is constant.
    """

    coordinates: tuple[Quantity, ...]
    steps: list[Let] = field(default_factory=list)
    known: dict[sp.Symbol, Slopes] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.known |= {q: {q: S.One} for q in self.coordinates}

    def let(self, symbol: Quantity, expr: Expr, reason: str = "") -> Quantity:
        """Name an expression, in the unit of ``symbol``, and return the symbol, whose derivatives
        are then known.
        """
        self.steps.append(Let(symbol, expr, f"derived: {reason or symbol.meaning}"))
        self.known[symbol] = self.slopes(expr)
        return symbol

    def slopes(self, expr: Expr) -> Slopes:
        """Return the derivatives of an expression along its coordinates [its unit per that of the
        coordinate].
        """
        if isinstance(expr, sp.Piecewise):
            return self._of_cases(expr)
        derivatives: Slopes = {}
        for symbol in sorted(expr.free_symbols & self.known.keys(), key=str):
            outer = expr.diff(symbol)
            for coordinate, inner in self.known[symbol].items():
                derivatives[coordinate] = derivatives.get(coordinate, S.Zero) + outer * inner
        return {coordinate: slope for coordinate, slope in derivatives.items() if slope != 0}

    def along(self, expr: Expr, coordinate: Quantity) -> Expr:
        """Return the derivative of an expression along one coordinate [its unit per that of the
        coordinate].
        """
        return self.slopes(expr).get(coordinate, S.Zero)

    def _of_cases(self, cases: sp.Piecewise) -> Slopes:
        parts = [(self.slopes(value), condition) for value, condition in cases.args]
        return {
            q: sp.Piecewise(*((slopes.get(q, S.Zero), condition) for slopes, condition in parts))
            for q in self.coordinates
            if any(q in slopes for slopes, _ in parts)
        }


_RATES = {"rad": ("rad/s", "rad/s2"), "m": ("m/s", "m/s2"), "1": ("1/s", "1/s2")}


@dataclass(frozen=True)
class GearStage:
    """A pair of non-circular gears whose pitch curves are chosen at run time: number and vectors of
    the inner gear.
    """

    number: int
    parameters: OpenVector
    hoisted: OpenVector

    @property
    def contact(self) -> RuntimeFunction:
        takes, gives = (
            ("t", "parameters", "hoisted"),
            ("r", "dr", "ddr", "ratio", "dratio", "turned"),
        )
        kind = "contact functions of pitch curves"
        return RuntimeFunction(f"stage{self.number}", kind, takes, gives, positive=("r", "ratio"))

    def call(self, argument: Expr, when: str = "", **outputs: Quantity) -> Call:
        """Contact at a polar angle of the inner gear; ``outputs`` are those of its results that
        have a use.
        """
        contact = self.contact
        named = tuple(outputs.get(name) for name in contact.gives)
        source = f"derived: stage {self.number}{when}"
        return Call(named, contact, argument, (self.parameters, self.hoisted), source)

    def joints(self, t: Quantity) -> list[Event]:
        """Return the events at which both segments of a deformed pitch curve meet; other curves
        have none.
        """
        deformation = self.parameters.known.get(-1)
        wheres = {"t = 0": S.Zero, "t = pi/m": sp.pi / deformation} if deformation else {}
        name = f"gear {self.parameters.suffix}"
        return [
            Event(f"{name}, {where}", t, target, order=1, period=2 * sp.pi)
            for where, target in wheres.items()
        ]


@dataclass(frozen=True)
class FollowerLaw:
    """The motion of a follower from one dwell to the next, by a law that is chosen at run time.

    ``joints`` are the positions in a flank, from 0 to 1 without unit, where a derivative of some
    law jumps.
    """

    name: str
    joints: tuple[Expr, ...] = (S.Zero, S.One)

    @property
    def function(self) -> RuntimeFunction:
        return RuntimeFunction(self.name, "laws of cam flanks", ("x",), ("p", "dp", "ddp"))


class Kinematics(Statement):
    """Statement of the motion of a mechanism: coordinates, named points and accelerations, gear
    stages, cam flanks.
    """

    def coordinate(
        self, name: str, unit: str, meaning: str, equals: Expr | None = None
    ) -> Quantity:
        """Return a coordinate in ``unit`` "rad", "m" or "1", with its rate ``name_dot`` and
        acceleration ``name_ddot``.

        The rate is in [rad/s], [m/s] or [1/s], the acceleration in that per s. Along an angle the
        coordinate is what ``equals`` says, or loops determine it (`close`, `constrain`); in free
        motion it is a degree of freedom. Raises MechanismError for another unit.

        >>> from derive import Mechanism, quantities
        >>> q = quantities('''
        ...     phi   | rad   | cam angle
        ...     omega | rad/s | its speed | 10
        ...     h     | m     | lift      | 0.01
        ... ''')
        >>> m = Mechanism("cam", q, angle=q.phi, speed=q.omega)
        >>> s = m.coordinate("s", "m", "lift", equals=q.h * q.phi**2)
        >>> s.unit, m.motion.rates[s].unit, [str(step.expr) for step in m.named]
        ('m', 'm/s', ['h*phi**2', '2*h*omega*phi', '2*h*omega**2'])
        """
        if unit not in _RATES:
            raise MechanismError(f"coordinate {name}: unit = {unit}: write {', '.join(_RATES)}")
        value = quantity(name, unit, meaning)
        rate = quantity(f"{name}_dot", _RATES[unit][0], f"{meaning}, rate")
        acceleration = quantity(f"{name}_ddot", _RATES[unit][1], f"{meaning}, acceleration")
        return self.follow((value, rate, acceleration), equals)

    def follow(
        self,
        symbols: tuple[Quantity, Quantity, Quantity],
        equals: Expr | None = None,
        at_start: Expr | None = None,
    ) -> Quantity:
        """State a coordinate, its rate and its acceleration by three quantities of the table, and
        return the first.

        The units are those of the quantities; ``equals`` is as in `coordinate`, ``at_start`` what
        the coordinate is at angle zero.

        >>> from derive import Mechanism, quantities
        >>> q = quantities('''
        ...     phi   | rad    | crank angle
        ...     omega | rad/s  | its speed | 10
        ...     psi   | rad    | planet
        ...     w     | rad/s  | planet, rate
        ...     a     | rad/s2 | planet, acceleration
        ... ''')
        >>> m = Mechanism("train", q, angle=q.phi, speed=q.omega)
        >>> m.rate(m.follow((q.psi, q.w, q.a), equals=-2 * q.phi))
        w
        """
        value, rate, acceleration = symbols
        if equals is None:
            self.loops.coordinates.append(Coordinate(value, rate, acceleration))
        else:
            velocity = self.motion.rate(equals)
            for symbol, expr in (
                (value, equals),
                (rate, velocity),
                (acceleration, self.motion.rate(velocity)),
            ):
                self.let(symbol, expr)
        self.motion.rates |= {value: rate, rate: acceleration}
        self.start |= {} if at_start is None else {value: at_start}
        return value

    def stage(
        self,
        stage: GearStage,
        t: Quantity,
        argument: Expr,
        *,
        r: Quantity,
        dr: Quantity,
        ratio: Quantity,
        dratio: Quantity,
        turned: Quantity,
        start: Quantity,
    ) -> None:
        """State the contact of a gear stage at the polar angle ``t`` = ``argument`` [rad] of its
        inner gear.

        The quantities ``r`` and ``dr`` are the pitch radius of the inner gear [m] and its slope
        over t [m]; ``ratio`` and ``dratio`` the speed ratio and its slope, without unit; ``turned``
        the angle by which the outer gear has turned [rad], ``start`` the same at angle zero. A
        deformed pitch curve adds events where its segments meet. Raises ValueError if the polar
        angle at angle zero is not known.
        """
        at_start = argument.xreplace(self.start)
        if moving := sorted(map(str, at_start.free_symbols & self.motion.rates.keys())):
            raise ValueError(
                f"stage {stage.number}: nothing says what {', '.join(moving)} is at {self.angle} "
                f"= 0"
            )
        self.let(t, argument)
        self.steps.append(stage.call(at_start, f", {self.angle} = 0", turned=start))
        self.steps.append(stage.call(t, r=r, dr=dr, ratio=ratio, dratio=dratio, turned=turned))
        rate = self.motion.rate(argument)
        self.motion.rates |= {t: rate, r: dr * rate, ratio: dratio * rate, turned: ratio * rate}
        self.events += stage.joints(t)

    def flank(
        self,
        law: FollowerLaw,
        name: str,
        angle: tuple[Quantity, Expr],
        ends: tuple[Expr, Expr],
        x: Quantity,
        pace: Quantity,
        shares: tuple[Quantity, Quantity, Quantity],
    ) -> None:
        """State a cam's flank between two angles ``ends`` [rad], by a law of motion that is chosen
        at run time.

        ``angle`` is the cam's angle within its turn, and as it grows over turns [rad]. ``x``
        becomes the position in the flank from 0 to 1, without unit, ``pace`` its slope over the
        angle [1/rad], and ``shares`` the share of the rise with its first and second slope over x,
        without unit. The joints of the law become events.
        """
        (within, grown), (start, end) = angle, ends
        place, (share, slope, bend) = (within - start) / (end - start), shares
        self.let(x, clip(place, S.Zero, S.One))
        self.let(pace, clip_slope(place, 1 / (end - start)))
        self.steps.append(Call(shares, law.function, x, (), f"derived: {x.meaning}"))
        passed = pace * self.motion.rates[within]
        self.motion.rates |= {x: passed, share: slope * passed, slope: bend * passed}
        wheres = {S.Zero: f"start of the {name}", S.One: f"end of the {name}"}
        self.events += [
            Event(
                f"cam, {wheres.get(at, f'{at} of the {name}')}",
                grown,
                start + at * (end - start),
                2,
                2 * sp.pi,
                at,
            )
            for at in law.joints
        ]

    def name_acceleration(self, point: Point, frame: Frame, symbols: tuple[Quantity, ...]) -> None:
        """Name the components of a point's acceleration [m/s2], along the axes of ``frame``, by
        ``symbols``.

        Example: `name_place`.
        """
        acceleration = self.motion.acceleration(point, frame)
        for symbol, component in zip(symbols, acceleration.components, strict=False):
            self.let(symbol, component)
        self.motion.accelerations[point] = _vector(frame, symbols, acceleration.components)

    def name_place(
        self, point: Point, base: Point, frame: Frame, symbols: tuple[Quantity, ...]
    ) -> None:
        """Name the components of the vector from ``base`` to a point [m], along the axes of
        ``frame``.

        Their rates [m/s] follow.

        >>> from derive import Mechanism, quantities
        >>> q = quantities('''
        ...     phi   | rad   | crank angle
        ...     omega | rad/s | its speed | 10
        ...     r     | m     | crank     | 0.05
        ...     x     | m     | pin, x
        ...     y     | m     | pin, y
        ...     ax    | m/s2  | pin, x
        ...     ay    | m/s2  | pin, y
        ... ''')
        >>> m = Mechanism("bar", q, angle=q.phi, speed=q.omega)
        >>> A = m.point("A", m.O, m.frame("crank", q.phi), q.r)
        >>> m.name_place(A, m.O, m.world, (q.x, q.y))
        >>> m.rate(q.x)
        -omega*y
        >>> m.name_acceleration(A, m.world, (q.ax, q.ay))
        >>> [str(step.expr) for step in m.named]
        ['r*cos(phi)', 'r*sin(phi)', '-omega**2*x', '-omega**2*y']
        """
        place = displacement(base, point, frame)
        for symbol, component in zip(symbols, place.components, strict=False):
            self.let(symbol, component)
        self.motion.places[point] = base, _vector(frame, symbols, place.components)
        drift = shorten_vector(self.motion.drift(base, point, frame))
        self.motion.rates |= dict(zip(symbols, drift.components, strict=False))

    def hang(self, point: Point, hinge: Point) -> None:
        """Count a named place [m] from ``hinge``, about which the point swings: its acceleration is
        derived from there.

        Raises KeyError if the place has no name (`name_place`).
        """
        base, named = self.motion.places[point]
        self.motion.places[point] = hinge, named - self.motion.arm(base, hinge, named.frame)

    def mirror_place(
        self, image: Point, point: Point, base: Point, frame: Frame, plane: Expr
    ) -> None:
        """Name the place [m] of a mirror image by that of its original; the mirror is z = ``plane``
        [m] of ``frame``.

        Raises ValueError if ``image`` is not the mirror image of ``point``.
        """
        place, meant = self.motion.arm(base, point, frame), displacement(base, point, frame)
        difference = displacement(base, image, frame) - Vec(
            frame, (meant[0], meant[1], 2 * plane - meant[2])
        )
        if any(sp.simplify(c) != 0 for c in difference.components):
            raise ValueError(f"{image.name} is not the mirror image of {point.name}")
        self.motion.places[image] = base, Vec(frame, (place[0], place[1], 2 * plane - place[2]))


def _vector(frame: Frame, symbols: tuple[Quantity, ...], defaults: tuple[Expr, Expr, Expr]) -> Vec:
    """A vector by names, and by other components where the names end."""
    components: list[Expr] = [*symbols, *defaults[len(symbols) :]]
    return Vec(frame, (components[0], components[1], components[2]))
