"""From poses to a two-stage non-circular planetary gear train, from geometry (patent CN107654585B,
steps 2 to 5).

Dyads (kinematic mapping): stated are two frames, a hinge that is fixed in one and lies on a circle
in the other, and a pose as a dual quaternion. Train: stated are that the first driver is fixed,
that the arm turns with the second follower, that two external meshes on a carrier roll at the pitch
points, and that the arm returns to its position after a revolution of the carrier. The ratios of
the two stages are in a constant proportion, which the rotations of the first stage determine.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import NamedTuple

import sympy as sp
from sympy import Abs, Expr, S, pi

from ...formulas import Formulas
from ...mechanics.frames import Frame, Motion, Point, Vec, displacement
from ...mechanics.frames import Z as UP
from ...quantity import Quantity
from . import quantities as q

WORLD = Frame("frame")
ARM = Frame("arm", WORLD, UP, q.phi)

ORIGIN = Point("O")
TIP = Point("tip", ORIGIN, Vec(WORLD, (q.d1, q.d2, S.Zero)))
MOVING_HINGE = Point("moving hinge", TIP, Vec(ARM, (q.x, q.y, S.Zero)))
NAMED_HINGE = Point("moving hinge, named", ORIGIN, Vec(WORLD, (q.X, q.Y, S.Zero)))
FIXED_HINGE = Point("fixed hinge", ORIGIN, Vec(WORLD, (q.X_c, q.Y_c, S.Zero)))

LEADING: tuple[Expr, ...] = (
    -q.a0,
    q.a0 * q.x,
    q.a0 * q.y,
    q.a1,
    q.a2,
    q.a2 * q.x,
    -q.a1 * q.x / 2,
    q.a3 / 4,
)
"""The term of each coefficient p that determines the scale of the form that it multiplies."""


def hinge_by_pose() -> tuple[Expr, Expr]:
    """Return the moving hinge in the fixed frame, by the pose."""
    X, Y, _ = displacement(ORIGIN, MOVING_HINGE, WORLD).components
    return X, Y


def pose_quaternion(real: Expr, axial: Expr) -> tuple[Expr, Expr, Expr, Expr]:
    """Return the mapping parameters of a pose from the unit quaternion of its rotation (Blaschke,
    Gruenwald).

    The dual part is half the translation times the rotation.
    """
    turn = sp.Quaternion(real, 0, 0, axial)
    dual = sp.Quaternion(0, q.d1, q.d2, 0) * turn
    return sp.expand(-dual.c / 2), sp.expand(dual.b / 2), turn.d, turn.a


def pose_by_mapping() -> dict[Quantity, Expr]:
    """Return the position of a pose by its mapping parameters, which are homogeneous."""
    first, second, _, _ = pose_quaternion(q.Z4, q.Z3)
    return sp.solve([first - q.Z1, second - q.Z2], [q.d1, q.d2], simplify=True)


def hinge_by_mapping() -> tuple[Expr, Expr]:
    """Return the moving hinge by the mapping parameters; the angle is replaced by the tangent of
    half of it.
    """
    half, position = sp.tan(q.phi / 2), pose_by_mapping()

    def mapped(coordinate: Expr) -> Expr:
        rational = coordinate.replace(
            lambda e: isinstance(e, sp.sin | sp.cos), lambda e: e.rewrite(sp.tan)
        )
        return sp.factor(rational.subs(half, q.Z3 / q.Z4).xreplace(position))

    X, Y = hinge_by_pose()
    return mapped(X), mapped(Y)


class HingeCircle(NamedTuple):
    """The circle about the fixed hinge: its equation, and its coefficients by centre and radius."""

    residual: Expr
    coefficients: dict[Quantity, Expr]


def hinge_circle() -> HingeCircle:
    """Return the circle of the moving hinge, at a constant distance from the fixed one."""
    away = displacement(FIXED_HINGE, NAMED_HINGE, WORLD)
    poly = sp.Poly(q.a0 * (q.L1**2 - away.dot(away)), q.X, q.Y)
    names = {q.X: 2 * q.a1, q.Y: 2 * q.a2, S.One: q.a3}
    named = sum(
        names.get(m, poly.coeff_monomial(m)) * m
        for m in (sp.prod(_powers(poly, k)) for k in poly.monoms())
    )
    unknown = [poly.coeff_monomial(m) - name for m, name in names.items()]
    return HingeCircle(named, sp.solve(unknown, [q.a1, q.a2, q.a3]))


def _powers(poly: sp.Poly, exponents: tuple[int, ...]) -> list[Expr]:
    return [gen**n for gen, n in zip(poly.gens, exponents, strict=True)]


def fixed_hinge() -> dict[Quantity, Expr]:
    """Return centre and radius by the coefficients of the circle."""
    named = hinge_circle().coefficients
    centre = sp.solve([named[k] - k for k in (q.a1, q.a2)], [q.X_c, q.Y_c])
    square = sp.Dummy(positive=True)
    (radius_square,) = sp.solve(named[q.a3].subs(q.L1**2, square).xreplace(centre) - q.a3, square)
    return {**centre, q.L1: sp.sqrt(sp.expand(radius_square))}


@cache
def linear_form() -> tuple[tuple[Expr, Expr], ...]:
    """Return the circle, by the mapping parameters, as a sum of eight products: dyad coefficient
    times pose form.

    Terms of the dyad that multiply proportional forms of the pose are collected.
    """
    X, Y = hinge_by_mapping()
    scaled = hinge_circle().residual.xreplace({q.X: X, q.Y: Y}) * (q.Z3**2 + q.Z4**2)
    poly = sp.Poly(sp.cancel(scaled) / 4, q.a0, q.a1, q.a2, q.a3, q.x, q.y)
    terms = {sp.prod(_powers(poly, exponents)): form for exponents, form in poly.terms()}
    products = []
    for leading in LEADING:
        factor, monomial = leading.as_coeff_Mul()
        form = sp.expand(terms[monomial] / factor)
        share = {m: sp.cancel(f / form) for m, f in terms.items()}
        products.append((sum(m * s for m, s in share.items() if s.is_number), form))
    return tuple(products)


def dyad_coefficients() -> dict[Quantity, Expr]:
    """Return the coefficients of the linear form by the dyad."""
    return {p: of_dyad for p, (of_dyad, _) in _numbered()}


def _numbered() -> Iterator[tuple[Quantity, tuple[Expr, Expr]]]:
    return zip(q.COEFFICIENTS, linear_form(), strict=True)


def matrix_row() -> dict[Quantity, Expr]:
    """Return the entries of a row of the matrix: the forms, in the mapping parameters of pose j."""
    at_j = dict(zip(q.MAPPED, q.MAPPED_J, strict=True))
    return {
        entry: form.xreplace(at_j)
        for entry, (_, form) in zip(q.ENTRIES, linear_form(), strict=True)
    }


def coefficient_conditions() -> tuple[Expr, Expr]:
    """Return the two conditions on the eight coefficients of a dyad, which six of them
    determine.
    """
    named = dyad_coefficients()
    dyad = [q.a0, q.x, q.y, q.a1, q.a2]
    fixed = sp.solve([named[p] - p for p in q.COEFFICIENTS[:5]], dyad, dict=True)[0]
    first, second = (sp.numer(sp.together(p - named[p].xreplace(fixed))) for p in (q.p6, q.p7))
    return sp.expand(first), sp.expand(second)


def null_vector() -> dict[Quantity, Expr]:
    """Return the vectors of the null space as linear combinations of a basis."""
    vector = sp.Matrix(q.BASIS).T * sp.Matrix(q.PARAMETERS)
    return dict(zip(q.COEFFICIENTS, vector, strict=True))


def conic_coefficients() -> tuple[dict[Quantity, Expr], dict[Quantity, Expr]]:
    """Return the coefficients K of the conditions on the null space by the basis."""
    first, second = (
        sp.Poly(condition.xreplace(null_vector()), *q.PARAMETERS)
        for condition in coefficient_conditions()
    )
    return _named(q.K1, first), _named(q.K2, second)


def _named(names: tuple[Quantity, ...], conic: sp.Poly) -> dict[Quantity, Expr]:
    return {name: conic.coeff_monomial(m) for name, m in zip(names, q.MONOMIALS, strict=True)}


def conic_form(names: tuple[Quantity, ...]) -> Expr:
    """Return the quadratic form with some coefficients."""
    return sum(name * m for name, m in zip(names, q.MONOMIALS, strict=True))


@cache
def derive_eliminant() -> sp.Poly:
    """Return the polynomial of alpha/gamma of a common solution: the resultant of the two conics
    over gamma^2.
    """
    scaled = [conic_form(names).xreplace({q.gamma: S.One}) for names in (q.K1, q.K2)]
    return sp.Poly(sp.resultant(*scaled, q.beta), q.alpha)


def zero_eigenvalues() -> int:
    """Return the number of zero eigenvalues of the transposed matrix times the matrix, for five
    general poses.

    The poses are on the moment curve.
    """
    poses = [dict(zip(q.MAPPED_J, (1, j, j**2, j**3), strict=True)) for j in range(1, 6)]
    matrix = sp.Matrix([[form.xreplace(pose) for form in matrix_row().values()] for pose in poses])
    square = matrix.T * matrix
    return square.cols - square.rank()


def add_dyads(f: Formulas) -> None:
    """Add the equations from a pose and a hinge to the conditions on the null space, and back to
    the dyad.
    """
    tip = displacement(ORIGIN, TIP, WORLD)
    for n, (name, expr, coordinate) in enumerate(
        zip("XY", hinge_by_pose(), (q.X, q.Y), strict=True)
    ):
        f.defines(coordinate, expr, f"moving hinge in the fixed frame by the pose, {name}")
        f.holds(
            f"coordinate {n + 1} of a pose",
            tip[n] - (q.X_o, q.Y_o)[n],
            defines=(q.X_o, q.Y_o)[n],
        )
    half = q.phi / 2
    for name, expr in zip(q.MAPPED, pose_quaternion(sp.cos(half), sp.sin(half)), strict=True):
        f.defines(name, expr, f"mapping parameter {name} of a pose")
    for name, expr in pose_by_mapping().items():
        f.holds(f"coordinate {name} of a pose by the mapping parameters", name - expr)
    for name, expr, coordinate in zip("XY", hinge_by_mapping(), (q.X, q.Y), strict=True):
        f.holds(
            f"moving hinge in the fixed frame by the mapping parameters, {name}", coordinate - expr
        )
    f.holds("moving hinge on a circle about the fixed hinge", hinge_circle().residual)
    for name, expr in hinge_circle().coefficients.items():
        f.defines(name, expr, f"coefficient {name} of the circle")
    for name, expr in fixed_hinge().items():
        f.defines(name, expr, f"{name} by the coefficients of the circle")
    arm = displacement(TIP, MOVING_HINGE, ARM)
    f.defines(q.L2, sp.sqrt(arm.dot(arm)), "length of the arm")
    for name, expr in dyad_coefficients().items():
        f.defines(name, expr, f"coefficient {name} of the linear form")
    f.holds("circle as a linear form", sum(p * form for p, (_, form) in _numbered()))
    for name, expr in matrix_row().items():
        f.defines(name, expr, f"entry {name} of the matrix")
    f.holds(
        "row of the linear system",
        sum(e * p for e, p in zip(q.ENTRIES, q.COEFFICIENTS, strict=True)),
    )
    for order, residual in zip(("first", "second"), coefficient_conditions(), strict=True):
        f.holds(f"{order} condition on the coefficients", residual)
    f.defines(q.n_zero, sp.Integer(zero_eigenvalues()), "zero eigenvalues of the squared matrix")
    for name, expr in null_vector().items():
        f.holds(f"vector in the null space, {name}", name - expr, named=True)
    for order, names, by_basis in zip(
        ("first", "second"), (q.K1, q.K2), conic_coefficients(), strict=True
    ):
        for name, expr in by_basis.items():
            f.defines(name, expr, f"{name} by the basis of the null space")
        f.holds(f"{order} condition on the null space", conic_form(names), named=True)
    f.defines(
        q.n_real,
        derive_eliminant().degree() - 2 * q.n_pairs,
        "real solutions of the two conditions",
    )


TURN = 2 * pi
CARRIER = Frame("carrier", WORLD, UP, q.theta)
MOTION = Motion(rates={q.theta: q.w1, q.phi: q.w2})

CARRIED_HINGE = Point(
    "moving hinge, on the carrier", FIXED_HINGE, Vec(CARRIER, (q.L1, S.Zero, S.Zero))
)
ANGLE_CURVE = q.phi - q.theta


def tip_position() -> dict[Quantity, Expr]:
    """Return the position of the tip: carrier and arm meet in the moving hinge."""
    by_arm, by_carrier = (
        displacement(ORIGIN, hinge, WORLD) for hinge in (MOVING_HINGE, CARRIED_HINGE)
    )
    return sp.solve([by_arm[0] - by_carrier[0], by_arm[1] - by_carrier[1]], [q.d1, q.d2])


def relative_rate(frame: Frame) -> Expr:
    """Return the rate of a body relative to the carrier."""
    return MOTION.spin(frame)[2] - MOTION.spin(CARRIER)[2]


def curve_slope() -> Expr:
    """Return the slope of the angle curve."""
    return MOTION.rate(ANGLE_CURVE) / MOTION.rate(q.theta)


def total_ratio() -> Expr:
    """Return the total ratio by the rates."""
    return sp.cancel(relative_rate(WORLD) / relative_rate(ARM))


def ratio_by_slope() -> Expr:
    """Return the total ratio by the slope of the angle curve."""
    speed = sp.solve(curve_slope() - q.slope, q.w2)[0]
    return sp.cancel(total_ratio().xreplace({q.w2: speed}))


def curve_rise() -> Expr:
    """Return the change of the angle curve over a revolution of the carrier, after which the arm is
    as before.
    """
    return sp.expand(ANGLE_CURVE.xreplace({q.theta: q.theta + TURN}) - ANGLE_CURVE)


def pitch_radii(ratio: Quantity, radius: Quantity) -> tuple[Expr, Expr]:
    """Return the pitch radii: the driver's by the ratio, the follower's by the driver's, the symbol
    ``radius``.

    At the pitch point, between the centres, both gears have one velocity. An external mesh reverses
    the rotation.
    """
    driver, follower, spin = sp.Symbol("driver"), sp.Symbol("follower"), sp.Symbol("spin")
    centre = Point("centre of the driver")
    other = Point("centre of the follower", centre, Vec(CARRIER, (q.a, S.Zero, S.Zero)))
    pitch = Point("pitch point", centre, Vec(CARRIER, (driver, S.Zero, S.Zero)))
    spins = Vec(CARRIER, (S.Zero, S.Zero, spin)), Vec(CARRIER, (S.Zero, S.Zero, -spin / ratio))
    arms = displacement(centre, pitch, CARRIER), displacement(other, pitch, CARRIER)
    slip = spins[0].cross(arms[0]) - spins[1].cross(arms[1])
    (by_ratio,) = sp.solve(slip[1], driver)
    (by_driver,) = sp.solve(follower + arms[1][0], follower)
    return sp.factor(by_ratio), by_driver.xreplace({driver: radius})


def polar_rates() -> tuple[Expr, ...]:
    """Return the rates of the polar angles at the contact per carrier angle, each in its positive
    direction.

    The contact is fixed in the carrier; on a gear it moves opposite to the gear's rotation.
    """
    first = -relative_rate(WORLD) / q.w1
    middle = -first / q.i1
    last = -middle / q.i2
    return first, -middle, -middle, last


def split_ratios() -> dict[Quantity, Expr]:
    """Return the ratios of the stages in the proportion x_s^2; their product is the total ratio."""
    first = sp.Dummy(positive=True)
    total, share = sp.Dummy(positive=True), sp.Dummy(positive=True)
    (root,) = sp.solve(first / (total / first) - share**2, first)
    back = {total: q.i, share: q.x_s}
    return {q.i1: root.xreplace(back), q.i2: sp.simplify(total / root).xreplace(back)}


def first_follower_rotation() -> Expr:
    """Return the integral of its polar rate over a revolution; constant factors are taken out of
    the integral.
    """
    rate = polar_rates()[1].xreplace(split_ratios())
    fixed, moving = rate.as_independent(q.i)
    if sp.simplify(moving - 1 / sp.sqrt(q.i)) != 0:
        raise ValueError(f"{moving} is not the quantity of which the mean is defined")
    return TURN * fixed * q.mean_root


def second_follower_rotation() -> Expr:
    """Return the integral of its polar rate over a revolution: a multiple of the slope, whose
    integral is the rise.
    """
    rate = polar_rates()[3].xreplace({q.i2: q.i / q.i1}).xreplace({q.i: ratio_by_slope()})
    return sp.cancel(rate / q.slope) * curve_rise()


def add_train(f: Formulas) -> None:
    """Add the equations of tip path, angle curve, ratios, split and pitch curves."""
    for name, expr in tip_position().items():
        f.defines(name, expr, f"coordinate {name} of the tip by the angles of carrier and arm")
    f.defines(q.y_rel, ANGLE_CURVE, "ordinate of the angle curve")
    f.holds("ordinates of the first and last point", Abs(q.y_last - q.y_first) - Abs(curve_rise()))
    f.defines(q.slope, sp.expand(curve_slope()), "slope of the angle curve")
    f.defines(q.i, total_ratio(), "total ratio by the speeds")
    f.holds("total ratio by the slope of the angle curve", q.i - ratio_by_slope())
    (closing,) = sp.solve(first_follower_rotation() - TURN, q.x_s)
    f.defines(q.x_s, closing, "split parameter")
    for name, expr in split_ratios().items():
        f.defines(name, expr, f"ratio {name} of a stage")
    for ratio, names in ((q.i1, (q.r1, q.r2)), (q.i2, (q.r3, q.r4))):
        for name, expr in zip(names, pitch_radii(ratio, names[0]), strict=True):
            f.defines(name, expr, f"pitch radius {name}")
    for gear, name, expr in zip(q.GEARS, q.POLAR_RATES, polar_rates(), strict=True):
        f.defines(name, expr, f"polar angle of the {gear}")
    f.defines(q.turn2, first_follower_rotation(), "turn of the first follower")
    f.defines(q.turn4, second_follower_rotation(), "turn of the second follower")
