"""Files of poses as the engine takes them: the gear train of the file's angle curve, or else a
four-bar linkage.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import casadi as ca
import numpy as np
import scipy

from planter.engine.closed_form import Event, build_closed_machine
from planter.engine.machine import Machine, Value
from planter.engine.piecewise import compose_pieces
from planter.errors import InputError
from planter.files import examples
from planter.kernels import Array
from planter.kernels.elimination import solve_system
from planter.kernels.formulas import load as load_formulas
from planter.numerics.arrays import TURN
from planter.papers.mapping.curve import AngleCurve, close_curve
from planter.papers.mapping.dyads import CONDITIONS, Dyad, distinct
from planter.papers.mapping.file import PoseFile, load_poses
from planter.papers.mapping.synthesis import Linkage, find_linkages
from planter.papers.mapping.train import Train

MODEL = "mapping_exact"
SPEED = "train.carrier_speed_rpm"
DYAD = ("x", "y", "X_c", "Y_c", "L1")
"""Names of a dyad's numbers in the derivation."""
STEPS = 8
"""Steps of Newton's method from the file's own dyads to those of other poses."""
CLOSED = 1e-9
"""Share of a dyad's size that the last of these steps may have."""
ARM = {
    "phi": ("rad", "direction of the arm"),
    "relative": ("rad", "rotation of the arm against the carrier"),
    "d1": ("m", "tip of the arm, x"),
    "d2": ("m", "tip of the arm, y"),
    "v1": ("m/s", "velocity of the tip, x"),
    "v2": ("m/s", "velocity of the tip, y"),
    "X": ("m", "moving hinge of the carrier, x"),
    "Y": ("m", "moving hinge of the carrier, y"),
}
"""Quantities of the arm, which is the coupler of a linkage; the carrier is its crank."""
FOLLOWER = {
    "X_f": ("m", "moving hinge of the follower, x"),
    "Y_f": ("m", "moving hinge of the follower, y"),
    "transmission": ("rad", "angle between coupler and follower, at most a right one"),
}
MEMBERS = ("the first driver", "the first follower", "the second driver", "the second follower")
GEARS = {
    "slope": (
        "1",
        "rotation of the arm per rotation of the carrier, against it, positive along its sense",
    ),
    "i": (
        "1",
        "ratio of the whole train: rotation of the carrier per relative rotation of the arm",
    ),
    "i1": ("1", "ratio of the first pair of gears"),
    "i2": ("1", "ratio of the second pair of gears"),
}
GEARS |= {f"r{k}": ("m", f"pitch radius of {gear}") for k, gear in enumerate(MEMBERS, 1)}
CONVEX = "curvature of the pitch curve of {}, positive where convex"
GEARS |= {f"kappa{k}": ("1/m", CONVEX.format(gear)) for k, gear in enumerate(MEMBERS, 1)}
VECTORS = {"tip_speed": ("v1", "v2")}


def takes(source: str) -> bool:
    """Return whether a source is a file of poses, or the name of a built-in one."""
    return examples.belongs_to_package(source, "mapping", {"pose"})


def load(source: str, changes: Mapping[str, float]) -> Machine:
    """Return the gear train of the [curve] of a file of poses, or else the four-bar linkage of its
    poses.

    The linkage is that of `points.linkage`, counted as in the results of the synthesis, or the
    first whose crank turns round. Raises InputError as the file does, or if the poses have no such
    linkage; ComputationError as the train does.
    """
    return build_machine(load_poses(source, changes))


def build_machine(file: PoseFile) -> Machine:
    """Return the gear train of a file with a [curve], else the linkage.

    Raises InputError and ComputationError so.
    """
    return build_linkage(file) if file.curve is None else build_train(file)


def build_linkage(file: PoseFile) -> Machine:
    """Return the four-bar linkage of poses over the angle of its crank: its values are the poses.

    Raises InputError if the poses have no linkage of that number, or none whose crank turns round.
    """
    poses = file.poses
    linkage = _choose_linkage(file, poses)
    values = (*_pose_values(file), Value("omega", "rad/s", "speed of the crank", SPEED))
    data = np.array([file.si(value.path) for value in values])
    d, theta, h = ca.SX.sym("d", len(values)), ca.SX.sym("theta"), ca.SX.sym("h", 2 * len(DYAD))
    symbols = ca.reshape(d[: poses.size], 3, len(poses)).T
    dyads = [_solve_dyad(symbols, dyad) for dyad in (linkage.bar.crank, linkage.bar.follower)]
    crank, follower = h[: len(DYAD)], h[len(DYAD) :]
    model = load_formulas(MODEL)
    phi = _compose_coupler(theta, crank, follower, linkage)
    across, axial = ca.vertsplit(model.function("transmission")(theta, phi, crank, follower))
    angle = ca.atan2(ca.fabs(across), axial)
    arm = _compose_arm(theta, phi, crank, d[-1])
    pose = ca.vertcat(arm["d1"], arm["d2"], phi)
    hinge = ca.vertsplit(model.function("hinge")(pose, follower[:2]))
    results = arm | dict(zip(FOLLOWER, (*hinge, ca.fmin(angle, np.pi - angle)), strict=True))
    machine = _build(
        file,
        values,
        data,
        ARM | FOLLOWER,
        results,
        (theta, d, h),
        ca.vertcat(*dyads),
        [(axial, {"name": "coupler square to follower", "order": 1, "period": None})],
    )
    if not np.isfinite(np.array(machine.prologue(data))).all():
        raise InputError(
            f"{file.source}: dyads {linkage.numbers} are double roots: small changes of poses "
            f"part them"
        )
    return machine


def build_train(file: PoseFile) -> Machine:
    """Return the gear train of a file's angle curve over the carrier's angle: its values are the
    curve and the dyad.

    The dyad is the file's own, or the first of its poses, which then does not change. Raises
    InputError and ComputationError for a curve that no train has.
    """
    curve = _file_curve(file)
    train = Train(curve, file.si("train.centre_distance_mm"))
    count = len(curve.carrier) - 1
    entries = [
        (
            f"relative_{k + 1}",
            "rad",
            "rotation of the arm at a point of the curve",
            f"curve.relative_deg[{k}]",
        )
        for k in range(count)
    ]
    entries += [
        ("a", "m", "centre distance of both stages", "train.centre_distance_mm"),
        ("omega", "rad/s", "speed of the carrier", SPEED),
    ]
    if file.dyad is not None:
        paths = [f"dyad.{key}_mm[{k}]" for key in ("moving_point", "centre") for k in (0, 1)]
        meanings = (
            "moving hinge in the arm's frame, x",
            "moving hinge in the arm's frame, y",
            "fixed hinge, x",
            "fixed hinge, y",
            "length of the carrier",
        )
        parts = zip(DYAD, meanings, (*paths, "dyad.radius_mm"), strict=True)
        entries += [(name, "m", meaning, path) for name, meaning, path in parts]
    values = tuple(Value(*entry) for entry in entries)
    data = np.array([file.si(value.path) for value in values])
    data[:count] = curve.relative[:-1]
    d, theta, h = ca.SX.sym("d", len(values)), ca.SX.sym("theta"), ca.SX.sym("h", 4 * count + 1)
    symbols = dict(zip([value.name for value in values], ca.vertsplit(d), strict=True))
    dyad = (
        ca.vertcat(*(symbols[name] for name in DYAD))
        if file.dyad is not None
        else ca.SX(_first_dyad(file).vector)
    )
    start = float(curve.carrier[0])
    turned = TURN * ca.floor((theta - start) / TURN)
    rows = ca.vertsplit(ca.reshape(h[:-1], count, 4).T)
    rest, *slopes = compose_pieces(theta - turned, curve.carrier[:-1], [row.T for row in rows], 4)
    relative = rest + curve.sense * theta
    slopes = [curve.sense * slope + float(order == 0) for order, slope in enumerate(slopes)]
    symbols |= {"x_s": h[-1], "slope": -slopes[0], "dslope": -slopes[1], "ddslope": -slopes[2]}
    model = load_formulas(MODEL)
    results = _compose_arm(theta, theta + relative, dyad, symbols["omega"]) | {"relative": relative}
    results |= (
        model.composed("gears", symbols)
        | model.composed("curvature", symbols)
        | {"slope": slopes[0]}
    )
    knots = [
        (theta - float(angle), {"name": f"point {k} of the curve", "order": 0, "period": TURN})
        for k, angle in enumerate(curve.carrier[:-1], 1)
    ]
    return _build(
        file,
        values,
        data,
        ARM | GEARS,
        results,
        (theta, d, h),
        _spline_prologue(train, len(values)),
        knots,
    )


def _build(
    file: PoseFile,
    values: Sequence[Value],
    data: Array,
    entries: Mapping[str, tuple[str, str]],
    results: Mapping[str, ca.SX],
    symbols: tuple[ca.SX, ca.SX, ca.SX],
    prologue: ca.SX | ca.Function,
    events: Sequence[Event],
) -> Machine:
    return build_closed_machine(
        file,
        build_machine,
        load_formulas(MODEL).sidecar,
        values,
        data,
        entries,
        results,
        symbols,
        prologue,
        events,
        SPEED,
        file.measure_limits,
        VECTORS,
    )


def _choose_linkage(file: PoseFile, poses: Array) -> Linkage:
    solution, linkages = find_linkages(poses)
    if solution.free:
        count = len(distinct(poses))
        reason = (
            f"its {count} different poses leave a family of linkages; {CONDITIONS} "
            f"independent ones settle them"
        )
        raise InputError(f"{file.source}: {reason}")
    numbers = range(1, len(linkages) + 1)
    turning = [number for number in numbers if linkages[number - 1].bar.turns_round]
    hint = (
        f"it must be one of {', '.join(map(str, turning))}"
        if turning
        else "no linkage of these poses turns round"
    )
    if file.points is not None:
        number = file.points.linkage
        if number not in numbers:
            raise file.input_error(
                "points.linkage", f"it must be from 1 to {len(linkages)}, the number of linkages"
            )
        if number not in turning:
            reach = np.degrees(linkages[number - 1].bar.reaches[0].span)
            raise file.input_error(
                "points.linkage", f"its crank turns over {reach:.4g} deg only; {hint}"
            )
        return linkages[number - 1]
    if not turning:
        raise InputError(f"{file.source}: {hint}: {len(linkages)} linkages pass the poses")
    return linkages[turning[0] - 1]


def _pose_values(file: PoseFile) -> list[Value]:
    parts = {"x": ("m", "x_mm"), "y": ("m", "y_mm"), "phi": ("rad", "phi_deg")}
    meanings = {
        "x": "tip of the arm in pose {}, x",
        "y": "tip of the arm in pose {}, y",
        "phi": "direction in pose {}",
    }
    return [
        Value(f"{part}_{k}", unit, meanings[part].format(k), f"pose[{k - 1}].{key}")
        for k in range(1, len(file.pose) + 1)
        for part, (unit, key) in parts.items()
    ]


def _solve_dyad(poses: ca.SX, start: Dyad) -> ca.SX:
    """Return the graph of a dyad (5,) of poses (n, 3) by Newton's method from another; not finite
    if that fails.

    Of more than five poses it is the dyad with the least sum of squared misses.
    """
    model, v = load_formulas(MODEL), ca.SX.sym("v", len(DYAD))
    squares = [model.function("distance")(poses[k, :].T, v) for k in range(poses.size1())]
    gaps = ca.vertcat(*squares)
    if len(squares) > CONDITIONS:
        misses = ca.sqrt(gaps + v[4] ** 2) - v[4]
        gaps = ca.gradient(ca.sumsqr(misses), v)
    step = solve_system(ca.jacobian(gaps, v), -gaps).solution
    function = ca.Function("step", [v, poses], [step])
    at, change = ca.SX(start.vector.tolist()), ca.SX.zeros(len(DYAD))
    for _ in range(STEPS):
        change = function(at, poses)
        at = at + change
    return at / (ca.norm_inf(change) <= CLOSED * ca.norm_inf(at))


def _compose_coupler(theta: ca.SX, crank: ca.SX, follower: ca.SX, linkage: Linkage) -> ca.SX:
    """Return the graph of the coupler's angle, which goes on beyond a turn; not finite where the
    loop cannot close.

    It is counted from the frame's direction or, if the crank is longer than the frame, from the
    crank, from which the line to the follower's fixed hinge strays by less than a right angle.
    """
    model, bar, pose = load_formulas(MODEL), linkage.bar, linkage.standings[0]
    of_cos, of_sin, alone = ca.vertsplit(model.function("loop")(theta, crank, follower))
    x, y = ca.vertsplit(follower[:2] - crank[:2])
    frame = follower[2:4] - crank[2:4]
    if bar.lengths[1] > bar.lengths[0]:
        turned, reference = theta + np.pi, theta + np.pi - ca.atan2(y, x)
    else:
        turned = ca.atan2(frame[1], frame[0])
        reference = turned - ca.atan2(y, x)
    cosine, sine = -of_cos, -of_sin
    strayed = ca.atan2(
        sine * ca.cos(reference) - cosine * ca.sin(reference),
        cosine * ca.cos(reference) + sine * ca.sin(reference),
    )
    phi = reference + strayed + pose.assembly * ca.acos(alone / ca.hypot(of_cos, of_sin))
    gap, _, slope = ca.vertsplit(model.function("closed")(theta, phi, crank, follower))
    return phi - gap / slope


def _compose_arm(theta: ca.SX, phi: ca.SX, dyad: ca.SX, omega: ca.SX) -> dict[str, ca.SX]:
    """Return the quantities of `ARM` by name, on a carrier that turns with a speed omega
    [rad/s].
    """
    results = dict(
        zip(
            ("d1", "d2", "X", "Y"),
            ca.vertsplit(load_formulas(MODEL).function("arm")(theta, phi, dyad)),
            strict=True,
        )
    )
    velocities = {f"v{k}": omega * ca.jacobian(results[f"d{k}"], theta) for k in (1, 2)}
    return results | velocities | {"phi": phi, "relative": phi - theta}


def _file_curve(file: PoseFile) -> AngleCurve:
    assert file.curve is not None
    carrier, relative = file.curve.carrier_deg, file.curve.relative_deg
    if len(carrier) != len(relative):
        raise InputError(
            f"{file.source}: curve.relative_deg: it must be as long as carrier_deg, {len(carrier)}"
        )
    places = [f"[curve] point {k}" for k in range(1, len(carrier) + 1)]
    return close_curve(file.source, places, np.column_stack([carrier, relative]))


def _first_dyad(file: PoseFile) -> Dyad:
    dyads = find_linkages(file.poses)[0].dyads
    if not dyads:
        raise InputError(
            f"{file.source}: its poses have no real dyad to carry the arm; [dyad] can name one"
        )
    return dyads[0]


def _spline_prologue(train: Train, count: int) -> ca.Function:
    """Return d (count,) -> coefficients of the curve less a uniform turn, power by power, and the
    split parameter.

    Coefficients are linear in the curve's points, which come first in d; the split parameter is the
    mean root of the slope, by the quadrature of the file's own curve.
    """
    curve = train.curve
    size = len(curve.carrier) - 1
    unit = scipy.interpolate.CubicSpline(
        curve.carrier, np.vstack([np.eye(size), np.eye(size)[:1]]), bc_type="periodic"
    )
    nodes, weights = train.panels()
    d = ca.MX.sym("d", count)
    rest = d[:size] - curve.sense * ca.DM(curve.carrier[:-1].tolist())
    coefficients = ca.DM(np.ascontiguousarray(unit.c.reshape(4 * size, size))) @ rest
    slopes = curve.sense * (ca.DM(np.ascontiguousarray(unit(nodes, 1))) @ rest) + 1
    x_s = ca.dot(ca.DM(weights.tolist()), ca.sqrt(slopes)) / TURN
    return ca.Function("prologue", [d], [ca.vertcat(coefficients, x_s)])
