"""A mechanism as it is drawn: frames, points, bodies, joints, forces.

What follows from them is derived.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence

import sympy as sp
from sympy import Expr, S

from ..model import Input, Lane, Let, Step, System
from ..quantity import (
    NONE,
    NOTHING,
    DimensionError,
    Quantities,
    Quantity,
    dimension,
    quantities,
    word,
)
from .bodies import AXES
from .driven_motion import Sides, derive_driven_motion, derive_twin_lane
from .frames import NO_AXIS, Axis, Frame, Motion, Point, Quaternion, Vec, Z, displacement, unit
from .free_motion import CoordinateMotion, derive_free_motion, symbolic_accelerations
from .joints import Joints, Scalar
from .statement import MechanismError, to_triple

TIME = Quantity("time", "s", "time", "given")
WORLD = Frame("world")


class Mechanism(Joints):
    """A plane or spatial mechanism: state frames, points, bodies, joints and forces, then derive
    the model by `system`.

    ``angle`` [rad] drives it at ``speed`` [rad/s], both quantities of the table ``given``; with
    ``acceleration`` [rad/s2] the speed changes at that rate, without it the speed is constant.
    Without an angle the mechanism moves freely on its constraints, and an integrator finds the
    motion. Raises MechanismError for an angle without a speed, or for another unit.

    Axes are right-handed and angles count counter-clockwise. Unless ``spatial``, bodies move in the
    plane x, y and turn about z. ``gravity`` [m/s2] is one number, the acceleration of free fall
    along -y of the world, or its three components along the axes of the world. Lengths are in m and
    all quantities in SI; a number without a quantity has no unit, so that a length is stated as a
    quantity. Every name becomes a name in the generated code: an identifier of Python, and none
    twice.

    A joint or force acts on the body ``on`` at a point, and its reverse acts on the body ``by`` at
    the same point. Results are named after it: F_ for forces and N_ for normal forces [N], M_ for
    moments [N m], P_ for powers [W].

    ``world`` is the frame at rest, ``O`` its origin (a Point), ``ground`` the body at rest,
    ``motion`` the `Motion`.

    >>> from derive import Mechanism, quantities
    >>> q = quantities('''
    ...     phi   | rad   | crank angle
    ...     omega | rad/s | speed of the crank | 10
    ...     g     | m/s2  | free fall          | 9.81
    ...     r     | m     | centroid           | 0.05
    ...     m     | kg    | mass of the crank  | 2
    ... ''')
    >>> m = Mechanism("crank", q, angle=q.phi, speed=q.omega, gravity=q.g)
    >>> turned = m.frame("crank", q.phi)
    >>> crank = m.body("crank", turned, q.m, m.point("C", m.O, turned, q.r))
    >>> m.pin("A", crank, m.ground, m.O)
    >>> m.motor("M_in", crank, m.ground, m.O)
    M_in
    >>> m.system(reported=["F_Ax", "F_Ay", "M_in"]).lane.outputs.quantities
    (F_Ax, F_Ay, M_in)
    """

    def __init__(
        self,
        name: str,
        given: Quantities = NOTHING,
        *,
        angle: Quantity | None = None,
        speed: Quantity | None = None,
        acceleration: Quantity | None = None,
        gravity: Scalar | Sequence[Scalar] = 0,
        title: str = "",
        source: str = "own",
        assumptions: Iterable[str] = (),
        spatial: bool = False,
        world: Frame = WORLD,
    ) -> None:
        if (angle is None) != (speed is None):
            raise MechanismError(
                f"{name}: an angle to move along needs its speed, and a speed an angle"
            )
        if acceleration is not None and angle is None:
            raise MechanismError(
                f"{name}: an acceleration is that of an angle to move along, which is lacking"
            )
        for driving, unit_ in ((angle, "rad"), (speed, "rad/s"), (acceleration, "rad/s2")):
            if driving is not None and driving.unit != unit_:
                raise MechanismError(
                    f"{name}: {driving} ({driving.meaning}) is in {driving.unit}, but a mechanism "
                    f"is driven along an "
                    "angle in rad at a speed in rad/s, which changes in rad/s2; state a length as "
                    "a coordinate that "
                    "the angle moves"
                )
        fall = gravity if isinstance(gravity, Sequence) else (0, -gravity, 0)
        changing = {} if acceleration is None else {speed: acceleration}
        motion = (
            CoordinateMotion({TIME: S.One}) if angle is None else Motion({angle: speed, **changing})
        )
        super().__init__(name, given, angle, motion, fall, spatial, world)
        self.title, self.source, self.speed = (
            title or name.replace("_", " ").capitalize(),
            source,
            speed,
        )
        self.acceleration = acceleration
        steady = (
            (f"constant: {speed.meaning}",) if speed is not None and acceleration is None else ()
        )
        self.assumptions = ("rigid bodies", *steady, *assumptions)

    @property
    def time(self) -> Quantity:
        """Time [s] as a quantity, for what is prescribed to a mechanism that moves freely."""
        return TIME

    def frame(self, name: str, angle: Scalar, axis: Axis = Z, parent: Frame | None = None) -> Frame:
        r"""Return a frame turned by ``angle`` [rad] about ``axis`` of its parent, in the
        right-handed sense.

        The parent is the world unless another frame is passed; the axis is X, Y, Z or the reverse
        of one, such as (0, 0, -1). Components v in the frame are R v in the parent, with Rodrigues'
        matrix R. Raises DimensionError if the angle is not in rad.

        >>> from derive import Mechanism, quantities
        >>> q = quantities("phi | rad | crank angle\nr | m | crank | 0.05")
        >>> m = Mechanism("bar", q)
        >>> m.vector(m.frame("crank", q.phi), q.r).resolved(m.world).components
        (r*cos(phi), r*sin(phi), 0)
        """
        try:
            angle_dimension = dimension(sp.sympify(angle))
        except DimensionError as error:
            raise DimensionError(f"frame {name}: {error}") from None
        if angle_dimension not in (None, NONE):
            raise DimensionError(f"frame {name}: its angle {angle} is not in rad")
        return Frame(name, parent or self.world, axis, sp.sympify(angle))

    def free_frame(
        self,
        name: str,
        parent: Frame | None = None,
        start: Sequence[tuple[Axis, Scalar]] = (),
        spin: Sequence[Scalar] = (0, 0, 0),
    ) -> Frame:
        r"""Return a frame that turns in any way against its parent, as on a ball joint or in free
        flight; in space.

        No pose is singular: the coordinates are the unit quaternion NAME_q0 (scalar), NAME_q1,
        NAME_q2, NAME_q3, without unit, which a gap keeps at length one. ``start`` lists turns
        (axis, angle [rad]), each about an axis X, Y or Z of the frame turned so far, which lead
        from the parent to the start; ``spin`` [rad/s] is the angular velocity against the parent
        there, along the frame's own axes. spin_NAMEx, spin_NAMEy, spin_NAMEz [rad/s], the absolute
        angular velocity along these axes, are reported. Raises MechanismError in the plane, along
        an angle, or for a start that is no list of turns.

        >>> from derive import Mechanism, X, quantities
        >>> q = quantities("m | kg | stone | 0.4\nA | kg m2 | x | 3e-4\nB | kg m2 | y | 5e-4\nC | kg m2 | z | 6e-4")
        >>> m = Mechanism("stone", q, spatial=True)
        >>> turned = m.free_frame("stone", start=[(X, 1.5)], spin=(0, 8, 0.01))
        >>> stone = m.body("stone", turned, q.m, m.O, (q.A, q.B, q.C))
        >>> m.ball("hold", stone, m.ground, m.O)
        >>> m.loops.gaps
        {'gap_stone': stone_q0**2 + stone_q1**2 + stone_q2**2 + stone_q3**2 - 1}
        """
        self._in_space(name)
        if self.angle is not None:
            raise MechanismError(
                f"{name}: a frame is free in free motion only; along an angle state its angles"
            )
        w, x, y, z = (
            self.coordinate(f"{name}_q{i}", "1", f"quaternion of {name}, {i}") for i in range(4)
        )
        now = Quaternion(w, (x, y, z))
        at = Quaternion(S.One, (S.Zero, S.Zero, S.Zero))
        for turn in start:
            if len(turn) != 2 or dimension(sp.sympify(turn[1])) not in (None, NONE):
                raise MechanismError(
                    f"frame {name}: start = {turn}: write (axis, angle), with the angle in rad"
                )
            half = sp.sympify(turn[1]) / 2
            at = at * Quaternion(sp.cos(half), to_triple([sp.sin(half) * a for a in turn[0]]))
        if len(spin) != 3:
            raise MechanismError(
                f"frame {name}: spin = {spin}: write its three components in rad/s"
            )
        rates = at * Quaternion(S.Zero, to_triple([sp.sympify(c) / 2 for c in spin]))
        for symbols, values in (
            ((w, x, y, z), at),
            ([self.motion.rates[c] for c in (w, x, y, z)], rates),
        ):
            self.begin(dict(zip(symbols, (values.scalar, *values.vector), strict=True)))
        self._add_gap(name, w**2 + x**2 + y**2 + z**2 - 1, {})
        frame = Frame(name, parent or self.world, NO_AXIS, now)
        for axis_name, speed in zip(AXES, self.motion.spin(frame).components, strict=True):
            self.report(
                f"spin_{name}{axis_name}",
                "rad/s",
                f"angular velocity of {name}, {axis_name} of {name}",
                speed,
            )
        return frame

    def point(
        self, name: str, base: Point, frame: Frame, x: Scalar = 0, y: Scalar = 0, z: Scalar = 0
    ) -> Point:
        r"""Return the point at the offset (x, y, z) [m] from ``base``, along the axes of ``frame``.

        The offset turns with the frame. Units are not checked here but where a force or a name
        needs the point.

        >>> from derive import Mechanism, quantities
        >>> q = quantities("phi | rad | crank angle\nr | m | crank | 0.05\nl | m | arm | 0.2")
        >>> m = Mechanism("bar", q)
        >>> A = m.point("A", m.O, m.frame("crank", q.phi), q.r)
        >>> m.position(m.point("B", A, m.world, q.l)).components
        (l + r*cos(phi), r*sin(phi), 0)
        """
        return Point(name, base, self.vector(frame, x, y, z))

    def vector(self, frame: Frame, x: Scalar = 0, y: Scalar = 0, z: Scalar = 0) -> Vec:
        """Return the vector with the components x, y, z along the axes of ``frame``, in the unit of
        the components.

        >>> from derive import Mechanism, quantities
        >>> m = Mechanism("bar", quantities("F | N | push | 5"))
        >>> m.vector(m.world, m.given.F).components
        (F, 0, 0)
        """
        return Vec(frame, to_triple((x, y, z)))

    def position(self, point: Point, frame: Frame | None = None) -> Vec:
        r"""Return the vector from the origin to a point [m], along the axes of the world or of
        ``frame``.

        >>> from derive import Mechanism, quantities
        >>> q = quantities("phi | rad | crank angle\nr | m | crank | 0.05")
        >>> m = Mechanism("bar", q)
        >>> turned = m.frame("crank", q.phi)
        >>> A = m.point("A", m.O, turned, q.r)
        >>> m.position(A).components, m.position(A, turned).components
        ((r*cos(phi), r*sin(phi), 0), (r, 0, 0))
        """
        return displacement(self.O, point, frame or self.world)

    def velocity(self, point: Point) -> Vec:
        r"""Return the velocity of a point against the world [m/s], along the axes of the world.

        >>> from derive import Mechanism, quantities
        >>> q = quantities("phi | rad | crank angle\nomega | rad/s | its speed | 10\nr | m | crank | 0.05")
        >>> m = Mechanism("bar", q, angle=q.phi, speed=q.omega)
        >>> m.velocity(m.point("A", m.O, m.frame("crank", q.phi), q.r)).components
        (-omega*r*sin(phi), omega*r*cos(phi), 0)
        """
        return self.motion.derivative(self.position(point))

    def close(self, first: Point, second: Point, start: Mapping[Quantity, Scalar]) -> None:
        """Close a loop: the two points coincide always, along x and y, in space also along z.

        It adds the gap [m] from ``first`` to ``second`` along each axis of the world, named after
        ``first``: ``Bx`` and ``By`` for a point B, as `derive.loop` names them in a paper. A loop
        determines as many coordinates as it has axes. ``start`` holds rough values of coordinates
        [rad or m] by quantity, at angle zero or at the start of free motion: Newton's method begins
        there, so they choose the branch. Raises MechanismError if a loop of that name exists;
        `system` raises LoopError unless there are as many gaps as coordinates without ``equals``,
        each with a start.

        >>> from derive import Mechanism, quantities
        >>> q = quantities('''
        ...     phi   | rad   | crank angle
        ...     omega | rad/s | speed       | 10
        ...     r     | m     | crank       | 0.05
        ...     l     | m     | rod         | 0.2
        ... ''')
        >>> m = Mechanism("slider_crank", q, angle=q.phi, speed=q.omega)
        >>> beta, s = m.coordinate("beta", "rad", "angle of the rod"), m.coordinate("s", "m", "place of the slider")
        >>> A = m.point("A", m.O, m.frame("crank", q.phi), q.r)
        >>> B = m.point("B", A, m.frame("rod", beta), q.l)
        >>> m.close(B, m.point("slot", m.O, m.world, s), start={beta: 0, s: q.l + q.r})
        >>> m.loops.gaps
        {'gap_Bx': -l*cos(beta) - r*cos(phi) + s, 'gap_By': -l*sin(beta) - r*sin(phi)}
        """
        gap = displacement(first, second, self.world)
        for axis, component in zip(
            AXES if self.spatial else AXES[:2], gap.components, strict=False
        ):
            self._add_gap(f"{first.name}{axis}", component, start)

    def parallel(
        self,
        name: str,
        first: tuple[Frame, Axis],
        second: tuple[Frame, Axis],
        start: Mapping[Quantity, Scalar],
    ) -> None:
        """Keep two axes parallel, as a hinge that closes a loop in space does in addition to
        `close`.

        Each of ``first`` and ``second`` is a frame and one of its axes X, Y, Z. It adds two gaps
        without unit: the components of the second axis across the first, in the first frame.
        ``start`` and errors are those of `close`.

        >>> from derive import Mechanism, X, Y, Z
        >>> m = Mechanism("loop", spatial=True)
        >>> a, b = m.coordinate("a", "rad", "first angle"), m.coordinate("b", "rad", "second angle")
        >>> leaf = m.frame("leaf", b, Y, m.frame("arm", a, X))
        >>> m.parallel("hinge", (m.world, Z), (leaf, Z), start={a: 0, b: 0})
        >>> m.loops.gaps
        {'gap_hingex': sin(b), 'gap_hingey': -sin(a)*cos(b)}
        """
        way = unit(*second).resolved(first[0])
        for axis, component in (
            (a, c)
            for a, c, is_parallel in zip(AXES, way.components, first[1], strict=True)
            if not is_parallel
        ):
            self._add_gap(f"{name}{axis}", component, start)

    def input(
        self,
        name: str,
        unit: str,
        meaning: str,
        start: float = 0,
        low: float | None = None,
        high: float | None = None,
    ) -> Quantity:
        r"""Return a quantity that a drive, a controller or a person sets while the mechanism moves.

        ``start`` is its value in the machine file, ``low`` and ``high`` what it can be, all in
        ``unit`` of SI. Forces, torques and laws may depend on it; places may not, since its rate is
        unknown. Raises TableError for an unknown unit, MechanismError for a name that the table has
        or for bounds that do not hold ``start``.

        >>> from derive import Mechanism, quantities
        >>> q = quantities("m | kg | cart | 2")
        >>> m = Mechanism("cart", q)
        >>> at = m.point("P", m.O, m.world, m.coordinate("s", "m", "place"))
        >>> cart = m.body("cart", m.world, q.m, at)
        >>> F = m.input("F", "N", "force of the drive", low=-50, high=50)
        >>> m.slide("rail", cart, m.ground, at)
        >>> m.force("push", cart, at, m.vector(m.world, F))
        >>> m.accelerations()
        (F/m,)
        """
        if name in self.given:
            raise MechanismError(f"{self.name}: input {name}: the table has this name")
        if not (-math.inf if low is None else low) <= start <= (math.inf if high is None else high):
            raise MechanismError(
                f"{self.name}: input {name}: start = {start} must be from low = {low} to "
                f"high = {high}"
            )
        table = quantities(f"{name} | {unit} | {meaning} | {start}")
        if table[name].unit != unit:
            raise MechanismError(
                f"{self.name}: input {name}: {unit}: an input is in SI, in {table[name].unit}"
            )
        self.given = Quantities({**self.given, **table}, {**self.given.data, **table.data})
        self.inputs[name] = low, high
        self.motion.inputs.add(table[name])
        return table[name]

    def begin(
        self, start: Mapping[Quantity, Scalar], hold: Iterable[Quantity] | None = None
    ) -> None:
        r"""Set where free motion starts: coordinates [rad or m] or their rates [rad/s or m/s] by
        quantity.

        All others are zero. The rate of a coordinate x is ``m.motion.rates[x]``. Values may be
        numbers or expressions of the table. Where constraints do not allow the start, values that
        are set hold and the others follow, by the least change that the inertia measures. If the
        set values contradict the constraints, ``hold`` names those that hold, coordinates or rates;
        without it the nearest start is used and the change reported
        (`planter.mechanism.dynamics.Dynamics.start`). Raises MechanismError if ``hold`` names
        anything else.

        >>> from derive import Mechanism, quantities
        >>> q = quantities("r | m | radius | 0.1\nv | m/s | speed | 2")
        >>> m = Mechanism("disc", q)
        >>> x, a = m.coordinate("x", "m", "hub"), m.coordinate("a", "rad", "turn")
        >>> m.roll("rim", m.rate(x) + q.r * m.rate(a))
        >>> m.begin({m.rate(x): q.v, m.rate(a): 5}, hold=[m.rate(x)])
        >>> m.start
        {x_dot: v, a_dot: 5}
        """
        self.start |= {q: sp.sympify(at) for q, at in start.items()}
        if hold is not None:
            hold = list(hold)
            names = [q for c in self.loops.coordinates for q in (c.value, c.rate)]
            if unknown_names := [str(q) for q in hold if q not in names]:
                raise MechanismError(
                    f"{self.name}: hold = {', '.join(unknown_names)}: it names coordinates and "
                    f"rates, which are "
                    f"{', '.join(map(str, names))}"
                )
            self.held_entries = [*(self.held_entries or ()), *map(str, hold)]

    def rate(self, expr: Expr) -> Expr:
        r"""Return the rate of change of an expression [its unit per s] by the chain rule over all
        coordinates.

        >>> from derive import Mechanism, quantities
        >>> q = quantities("phi | rad | crank angle\nomega | rad/s | its speed | 10")
        >>> Mechanism("bar", q, angle=q.phi, speed=q.omega).rate(q.phi**2)
        2*omega*phi
        """
        return self.motion.rate(expr)

    def twin_lane(
        self,
        sides: Sides,
        inputs: Sequence[Input],
        forces: Sequence[Step] | None = None,
        frame: Sequence[Let] | None = None,
    ) -> Lane:
        """Return the lane of one of two equal sides, half a turn apart, with the totals of both.

        ``inputs`` are packed inputs. ``sides`` names the quantities to report of a side and of both
        (`derive.Sides`), in SI. Bodies stated as ``shared`` carry the actions of both sides.
        ``forces`` (steps for the actions of a side) and ``frame`` (steps for those on the shared
        bodies) replace the solution of the balances. Raises MechanismError without an angle or for
        balances that no action satisfies, ChainError or DimensionError if the balances cannot be
        solved.
        """
        return derive_twin_lane(self, sides, inputs, forces, frame)

    def accelerations(self) -> tuple[Expr, ...]:
        r"""Return the accelerations [rad/s2 or m/s2] of the coordinates of free motion, in their
        order, as expressions.

        Raises MechanismError if loops or rolling constrain the coordinates.

        >>> from derive import Mechanism, quantities
        >>> q = quantities("F | N | push | 5\nm | kg | block | 2")
        >>> m = Mechanism("block", q)
        >>> at = m.point("P", m.O, m.world, m.coordinate("s", "m", "place"))
        >>> block = m.body("block", m.world, q.m, at)
        >>> m.slide("guide", block, m.ground, at)
        >>> m.force("push", block, at, m.vector(m.world, q.F))
        >>> m.accelerations()
        (F/m,)
        """
        return symbolic_accelerations(self, TIME)

    def system(self, reported: Sequence[str | Quantity] | None = None) -> System:
        r"""Derive the model: results along the angle, or the functions that an integrator needs;
        all values in SI.

        ``reported`` names the results, None stands for all: coordinates with rates and
        accelerations, named expressions (`name_`, `let`, `report`), actions of joints and, along an
        angle, residuals ``law_...`` of momentum and power, which vanish. Free motion adds
        ``kinetic`` and ``potential`` energy [J].

        Raises MechanismError for a result of an unknown name, if two quantities have one name, or
        if balances are left that no joint or drive can keep; LoopError if loops and coordinates
        differ in number; ChainError if balances do not determine a force; DimensionError if terms
        of different units are added.

        >>> from derive import Mechanism, quantities
        >>> q = quantities("phi | rad | crank angle\nomega | rad/s | its speed | 10\nr | m | crank | 0.05")
        >>> m = Mechanism("bar", q, angle=q.phi, speed=q.omega)
        >>> place = m.position(m.point("A", m.O, m.frame("crank", q.phi), q.r))
        >>> height = m.report("height", "m", "height of the pin", place[1])
        >>> m.system(reported=[height]).lane.outputs.quantities
        (height,)
        """
        self.refuse_shared_names()
        elements = {word(name): e.describe() for name, e in self.elements.items()}
        if self.angle is not None and self.speed is not None:
            lane, functions, loads = derive_driven_motion(
                self, self.angle, self.speed, self.acceleration, reported
            )
            return System(
                self.name,
                self.title,
                self.source,
                self.assumptions,
                lane,
                functions,
                self.given.data,
                pushing=tuple(force.name for force in self.pushing if force in lane.outputs),
                axes=self.component_axes,
                meshes={
                    tag: (inner.name, outer.name) for tag, (inner, outer, _) in self.meshing.items()
                },
                supports=self.name_supports(lane.outputs.quantities),
                loads=tuple(load.describe() for load in loads),
                elements=elements,
            )
        functions, added_inertia = derive_free_motion(self, TIME, reported)
        return System(
            self.name,
            self.title,
            self.source,
            self.assumptions,
            None,
            functions,
            self.given.data,
            axes=self.component_axes,
            begun=tuple(map(str, self.start)),
            open_inputs=self.inputs,
            held_entries=None if self.held_entries is None else tuple(self.held_entries),
            added_inertia=added_inertia,
            elements=elements,
        )
