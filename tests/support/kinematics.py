"""Motion of the planting device, written from its geometry and from nothing in `derive` or
`generated`.

Angles, places, their rates and accelerations of one side; the directions of tooth and cam forces.
Numbers come from a machine file. Every function serves arrays of carrier angles and mpmath numbers
alike.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from types import ModuleType

from planter.papers.planting.file import PlantingMachine
from tests.support.arithmetic import FLOATS, Arithmetic, Number
from tests.support.jets import Jet, Place, added, turned_y, turned_z

Curve = Callable[[Jet], Jet]


@dataclass(frozen=True)
class Gear:
    """A pitch curve r0(u), its two-segment deformation, its conjugate at the distance that closes
    one turn for one.
    """

    ops: Arithmetic
    radius: Curve
    m: Number

    @cached_property
    def distance(self) -> Number:
        """Centre distance at which the ratio's mean over u is 1, by Newton's method from below."""
        pi, integral = self.ops.xp.pi, self.ops.integral
        distance = 2 * integral(self._r, pi) / pi
        for _ in range(7):
            excess = integral(lambda u: self._ratio(u, distance), pi) - pi  # noqa: B023
            slope = -integral(lambda u: self._r(u) / (distance - self._r(u)) ** 2, pi)  # noqa: B023
            distance = distance - excess / slope
        return distance

    def _r(self, u: Number) -> Number:
        return self.radius(Jet(self.ops.xp, u)).value

    def _ratio(self, u: Number, distance: Number) -> Number:
        r = self._r(u)
        return r / (distance - r)

    def first_segment(self, t: Number) -> tuple[Number, bool]:
        """Polar angle within the turn, and whether it lies on the first segment."""
        angle = t - 2 * self.ops.xp.pi * self.ops.xp.floor(t / (2 * self.ops.xp.pi))
        return angle, angle * self.m < self.ops.xp.pi

    def contact(self, t: Jet) -> tuple[Jet, Jet, Jet]:
        """Pitch radius, its slope and the conjugate's ratio at the polar angle t."""
        angle, first = self.first_segment(t.value)
        m2 = self.m / (2 * self.m - 1)
        tau = Jet(t.xp, angle, t.rate, t.acceleration)
        u = (self.m * tau).where(first, m2 * (2 * t.xp.pi - tau))
        r = self.radius(u)
        unit = Jet(t.xp, u.value, t.xp.where(first, self.m, -m2) + 0 * u.value, 0 * u.value)
        along_radius = self.radius(unit)
        return r, along_radius.rate, r / (self.distance - r)

    def turned(self, t: Number) -> Number:
        """Rotation of the conjugate since t = 0: the integral of the ratio over t."""
        xp, m2 = self.ops.xp, self.m / (2 * self.m - 1)
        angle, first = self.first_segment(t)
        u = xp.where(first, self.m * angle, m2 * (2 * xp.pi - angle))
        part = self.ops.integral(lambda v: self._ratio(v, self.distance), u)
        return t - angle + xp.where(first, part / self.m, 2 * xp.pi - part / m2)


def eccentric_circle(radius: Number, eccentricity: Number) -> Curve:
    def curve(u: Jet) -> Jet:
        rise = eccentricity * u.sin()
        return eccentricity * u.cos() + (radius**2 - rise * rise).sqrt()

    return curve


def ellipse(semi_axis: Number, eccentricity: Number) -> Curve:
    return lambda u: semi_axis * (1 - eccentricity**2) / (1 - eccentricity * u.cos())


def limacon(mean: Number, amplitude: Number) -> Curve:
    return lambda u: mean + amplitude * u.cos()


def fourier(*coefficients: Number) -> Curve:
    def curve(u: Jet) -> Jet:
        terms = [c * (k * u).cos() for k, c in enumerate(coefficients)]
        return sum(terms[1:], terms[0])

    return curve


def sine(distance: Number, amplitude: Number) -> Curve:
    """The radius at which the ratio is 1 + c cos u."""

    def curve(u: Jet) -> Jet:
        ratio = 1 + amplitude * u.cos()
        return distance * ratio / (1 + ratio)

    return curve


FAMILIES: dict[str, tuple[Callable[..., Curve], tuple[str, ...]]] = {
    "eccentric_circle": (eccentric_circle, ("R{}_mm", "e{}_mm")),
    "ellipse": (ellipse, ("A{}_mm", "k{}")),
    "limacon": (limacon, ("l{}_mm", "b{}_mm")),
    "fourier": (fourier, ("c0{}_mm", "c1{}_mm", "c2{}_mm", "c3{}_mm")),
    "sine": (sine, ("D{}_mm", "c{}")),
}
"""Curve and names of its parameters in the design, where {} is the number of the gear."""


def _modified_sine(x: Jet) -> Jet:
    pi = x.xp.pi
    wave = (x * (4 * pi)).sin() * 0.25
    middle = 2 + x * pi - 2.25 * ((x * 4 + 1) * (pi / 3)).sin()
    ends = x * pi - wave
    return middle.where(x.value > 0.125, ends).where(x.value < 0.875, ends + 4) * (1 / (4 + pi))


def _modified_trapezoid(x: Jet) -> Jet:
    pi = x.xp.pi
    wave = (x * (4 * pi)).sin() * (1 / (2 * pi))
    start, y, rest = x * 2 - wave, x - 0.125, 1 - x
    up = y * y * (4 * pi) + y * 2 + (0.25 - 1 / (2 * pi))
    z = rest - 0.125
    down = 2 + pi - (z * z * (4 * pi) + z * 2 + (0.25 - 1 / (2 * pi)))
    across = x * (2 * (1 + pi)) + wave - pi / 2
    end = 2 + pi - (rest * 2 + wave)
    speed = up.where(x.value > 0.125, start).where(x.value < 0.375, across)
    return speed.where(x.value < 0.625, down).where(x.value < 0.875, end) * (1 / (2 + pi))


FLANKS: dict[str, Callable[[Jet], Jet]] = {
    "4-5-6-7 polynomial": lambda x: x * x * x * x * (35 + x * (-84 + x * (70 - 20 * x))),
    "3-4-5 polynomial": lambda x: x * x * x * (10 + x * (-15 + 6 * x)),
    "cycloidal": lambda x: x - (x * (2 * x.xp.pi)).sin() * (1 / (2 * x.xp.pi)),
    "harmonic": lambda x: 0.5 - 0.5 * (x * x.xp.pi).cos(),
    "modified sine": _modified_sine,
    "modified trapezoid": _modified_trapezoid,
}
"""Laws of a cam's flank as textbooks print them (Norton, Cam Design and Manufacturing Handbook)."""
INNER_JOINTS = {"modified sine": (1 / 8, 7 / 8), "modified trapezoid": (1 / 8, 3 / 8, 5 / 8, 7 / 8)}
"""Positions between a flank's ends at which a law is not smooth."""


def flank(law: str, x: Jet) -> Jet:
    """A law, resting before 0 and after 1."""
    return FLANKS[law](x).where(x.value > 0, 0).where(x.value < 1, 1)


@dataclass(frozen=True)
class Device:
    """Geometry of a machine in one of the number systems."""

    machine: PlantingMachine
    ops: Arithmetic = FLOATS

    def __getitem__(self, name: str) -> Number:
        return self.ops.number(self.machine.si(name))

    def vector(self, name: str) -> tuple[Number, Number, Number]:
        return self[f"{name}[0]"], self[f"{name}[1]"], self[f"{name}[2]"]

    @cached_property
    def sun(self) -> Gear:
        return self._gear(self.machine.stage1.family, "3")

    @cached_property
    def gear6(self) -> Gear:
        return self._gear(self.machine.stage2.family, "6")

    def _gear(self, family: str, number: str) -> Gear:
        curve, names = FAMILIES[family]
        parameters = [self[f"design.{name.format(number)}"] for name in names]
        return Gear(self.ops, curve(*parameters), self[f"design.m{number}1"])

    @cached_property
    def start(self) -> tuple[Number, Number]:
        """Rotations of both conjugates that belong to phi = 0."""
        return self.sun.turned(self["design.alpha3_deg"]), self.gear6.turned(
            self["design.beta6_deg"]
        )

    def side(self, phi: Number) -> Side:
        """Side 1 at a carrier angle; side 2 is `side(phi - pi)`."""
        return Side(self, Jet(self.ops.xp, phi, self["speed_rpm"], 0 * phi))


@dataclass(frozen=True)
class Side:
    """One side in motion: its carrier angle phi is a jet of time, and so is everything else."""

    device: Device
    phi: Jet

    def const(self, x: Number, y: Number, z: Number = 0) -> Place:
        return Jet(self.phi.xp, x), Jet(self.phi.xp, y), Jet(self.phi.xp, z)

    @cached_property
    def t1(self) -> Jet:
        return self.phi + self.device["design.alpha3_deg"]

    @cached_property
    def phi52(self) -> Jet:
        ratio = self.device.sun.contact(self.t1)[2]
        return (ratio * self.t1.rate).integrated(
            self.device.sun.turned(self.t1.value) - self.device.start[0]
        )

    @cached_property
    def t2(self) -> Jet:
        return self.phi52 + self.device["design.beta6_deg"]

    @cached_property
    def phi72(self) -> Jet:
        ratio = self.device.gear6.contact(self.t2)[2]
        speed = Jet(self.phi.xp, self.t2.rate, self.t2.acceleration)
        return (-ratio * speed).integrated(
            self.device.start[1] - self.device.gear6.turned(self.t2.value)
        )

    @cached_property
    def nozzle(self) -> Jet:
        """Angle of x' in the global frame, -alpha."""
        return self.phi + self.phi72 + (self.device["design.theta_deg"] - self.phi.xp.pi)

    @cached_property
    def delta(self) -> Jet:
        turns = self.phi.xp.floor(-self.phi72.value / (2 * self.phi.xp.pi))
        return -self.phi72 - 2 * self.phi.xp.pi * turns

    @cached_property
    def theta1(self) -> Jet:
        def at(edges: str) -> Jet:
            start, end = self.device[f"{edges}[0]"], self.device[f"{edges}[1]"]
            return flank(self.device.machine.cam.flank, (self.delta - start) / (end - start))

        return self.device["cam.opening_deg"] * (
            at("cam.rise_delta_deg") - at("cam.fall_delta_deg")
        )

    @cached_property
    def line1(self) -> Jet:
        """Direction of the line O-A1."""
        return self.phi + self.phi.xp.pi / 2

    @cached_property
    def line2(self) -> Jet:
        """Direction of the line A1-B1."""
        return self.line1 + self.device["design.gamma_deg"]

    @cached_property
    def A1(self) -> Place:
        return turned_z(self.line1, self.const(self.device.sun.distance, 0))

    @cached_property
    def B1(self) -> Place:
        return added(self.A1, turned_z(self.line2, self.const(self.device.gear6.distance, 0)))

    @cached_property
    def CA(self) -> Place:
        direction = self.phi + self.phi52 + self.device["centroid.middle_angle_deg"]
        return added(
            self.A1, turned_z(direction, self.const(self.device["centroid.middle_radius_mm"], 0))
        )

    @cached_property
    def CB(self) -> Place:
        x, y = self.device["centroid.planet_xy_mm[0]"], self.device["centroid.planet_xy_mm[1]"]
        return self.on_planet(self.const(x, y))

    def on_planet(self, place: Place) -> Place:
        """A place given in x'y'z'."""
        return added(self.B1, turned_z(self.nozzle, place))

    def on_half(self, name: str, outer: bool = False) -> Place:
        """A point of the inner half or of its mirror image; the mirror plane is put at z' = 0."""
        mirror = -1 if outer else 1
        hinge, (x, y, z) = self.device.vector("nozzle.hinge_A_mm"), self.device.vector(name)
        swung = turned_y(mirror * self.theta1, self.const(x, y, mirror * z))
        return self.on_planet(added(self.const(hinge[0], hinge[1], mirror * hinge[2]), swung))

    @cached_property
    def roller(self) -> Place:
        """The roller centre in x'y'z'."""
        hinge, angle = (
            self.device.vector("nozzle.hinge_A_mm"),
            self.theta1 + self.device["cam.psi0_deg"],
        )
        length, across = (
            self.device["cam.rocker_length_mm"],
            self.const(0, self.device["cam.base_radius_mm"])[1],
        )
        return hinge[0] - length * angle.cos(), across, hinge[2] + length * angle.sin()

    @cached_property
    def sliding(self) -> tuple[Number, Number]:
        """Velocity of the roller centre relative to the carrier, x' and z'."""
        relative = self.nozzle - self.phi
        seen = turned_z(relative, self.roller)
        x = relative.cos().value * seen[0].rate + relative.sin().value * seen[1].rate
        return x, seen[2].rate

    @cached_property
    def cam_direction(self) -> tuple[Number, Number]:
        """The cam's force on the roller per size, x' and z': normal to the sliding, turned against
        it by friction.
        """
        xp, (x, z), mu = self.phi.xp, self.sliding, self.device["contact.cam_friction_angle_deg"]
        speed = xp.sqrt(x**2 + z**2)
        up = xp.where(x > 0, 1, -1)
        across, tangential = (-z * up / speed, x * up / speed), (x / speed, z / speed)
        first, second = (
            xp.cos(mu) * n - xp.sin(mu) * s for n, s in zip(across, tangential, strict=True)
        )
        return first, second

    @cached_property
    def spring(self) -> Number:
        x, _, z = self.device.vector("nozzle.hook_F_mm")
        hook = turned_y(self.theta1, self.const(x, 0, z))[2].value
        return self.device["spring.preload_N"] + self.device["spring.rate_N_m"] * 2 * (z - hook)

    def mesh(self, stage: int) -> Mesh:
        """The tooth contact of stage 1 at P or of stage 2 at Q."""
        gear, t, line, inner = {
            1: (self.device.sun, self.t1, self.line1, self.const(0, 0)),
            2: (self.device.gear6, self.t2, self.line2, self.A1),
        }[stage]
        r, slope, _ = gear.contact(t)
        # The sun's polar angle at the contact grows counter-clockwise; gear 6 turns that way past
        # its contact.
        tangent = self.phi.xp.arctan2(r.value, slope if stage == 1 else -slope)
        lean = (
            self.device["contact.pressure_angle_deg"]
            - self.device["contact.tooth_friction_angle_deg"]
        )
        x, y, _ = added(inner, turned_z(line, (r, *self.const(0, 0)[1:])))
        return Mesh(t.xp, line.value, gear.distance - r.value, tangent, lean, (x.value, y.value))

    def weights(self) -> list[tuple[str, Place]]:
        """Every mass of the side with its centroid."""
        weights = [("mass.middle_kg", self.CA), ("mass.planet_kg", self.CB)]
        parts = [("mass.half_C1_kg", "nozzle.C1_mm"), ("mass.half_C2_kg", "nozzle.C2_mm")]
        return weights + [
            (mass, self.on_half(at, outer)) for mass, at in parts for outer in (False, True)
        ]


@dataclass(frozen=True)
class Mesh:
    """Tooth contact at the pitch point; `lean` is the angle of the tooth force to the common
    tangent.
    """

    xp: ModuleType
    line: Number
    outer_radius: Number
    tangent: Number
    lean: Number
    place: tuple[Number, Number]

    def from_line(self, flank: Number) -> Number:
        """Angle from the line of centres to the force on the inner gear, from the flank that turns
        the outer one with (+1) or against it (-1).
        """
        return self.tangent + self.xp.where(flank > 0, self.lean, self.xp.pi - self.lean)

    def direction(self, flank: Number) -> tuple[Number, Number]:
        """Unit force on the inner gear from a flank."""
        angle = self.line + self.from_line(flank)
        return self.xp.cos(angle), self.xp.sin(angle)

    def lever(self, flank: Number) -> Number:
        """Moment of the reaction about the outer gear's centre, per force."""
        return self.outer_radius * self.xp.sin(self.from_line(flank))

    def force(self, moment: Number) -> tuple[Number, Number]:
        """Force on the inner gear for the moment of its reaction about the outer gear's centre."""
        flank = self.xp.where(moment > 0, 1, -1)
        size = moment / self.lever(flank)
        x, y = self.direction(flank)
        return size * x, size * y
