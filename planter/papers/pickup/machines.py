"""Pick-ups as the engine takes them: the arm's law, bars and gears over the carrier's angle from
the farthest tip.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import casadi as ca
import numpy as np
import scipy

from planter.engine.closed_form import build_closed_machine
from planter.engine.machine import Machine, Value
from planter.engine.piecewise import compose_pieces
from planter.errors import InputError
from planter.files import csv_rows, examples
from planter.gears.geometry.flanks import TEETH
from planter.kernels.formulas import load as load_formulas
from planter.numerics.arrays import TURN
from planter.papers.pickup import file
from planter.papers.pickup.file import HEADER
from planter.papers.pickup.law import (
    MODEL,
    ROUNDING,
    SplineLaw,
    compose_smooth_law,
    toothed_range,
)
from planter.papers.pickup.model import PickupTrain, build_train

SPEED = "carrier.speed_deg_per_s"
STAGES = {
    "L1": ("m", "distance from the sun's centre to the planet's axis", "bars.L1_mm"),
    "L2": ("m", "distance from the planet's axis to the tip", "bars.L2_mm"),
    "gamma": ("rad", "bend of the carrier at the intermediate axis", "carrier.gamma_deg"),
    "a2": ("m", "centre distance of the helical stage", "carrier.a2_mm"),
    "omega": ("rad/s", "speed of the carrier", SPEED),
    "m_n": ("m", "normal module of the helical pair", "helical_stage.mn_mm"),
    "z_1": ("1", "teeth of the helical gear on the intermediate axis", "helical_stage.z1"),
    "z_2": ("1", "teeth of the planet", "helical_stage.z2"),
    "B": ("m", "face width of the helical pair", "helical_stage.B_mm"),
    "alpha_n": ("rad", "normal pressure angle of the helical pair", "helical_stage.alpha_n_deg"),
    "ha_n": ("1", "addendum coefficient of the helical pair", "helical_stage.ha"),
    "module": ("m", "module of the non-circular pair", "noncircular_stage.m_mm"),
    "ha1": ("1", "addendum coefficient of the sun", "noncircular_stage.ha1"),
    "ha2": ("1", "addendum coefficient of the intermediate gear", "noncircular_stage.ha2"),
    "alpha0": ("rad", "pressure angle of the non-circular pair", "noncircular_stage.alpha0_deg"),
    "mounting": ("rad", "direction of the needle from that of the arm", "needle.mounting_deg"),
    "entry": ("m", "depth of the farthest tip in the cell", "targets.entry_depth_mm"),
}
"""Unit, meaning and path of the numbers that every pick-up has, by name; a path of the tip gives
the bars.
"""
LAW = {
    "phi5_far": ("rad", "direction of the carrier where the tip is farthest", "law.phi5_far_deg"),
    "p": ("1", "swing of the arm's slope over its mean on the teeth", "law.p"),
    "dwell_start": ("rad", "where the dwell begins, from the farthest tip", "law.dwell_t_deg[0]"),
    "dwell_end": ("rad", "where the dwell ends, from the farthest tip", "law.dwell_t_deg[1]"),
    "transition": ("rad", "width of the smooth ends of the dwell", "law.transition_deg"),
}
"""The same for the numbers of a law."""
MOTION = {
    "phi1": ("rad", "angle of the arm against the carrier, counted on"),
    "arm": ("rad", "direction of the arm, planet's axis to tip"),
    "g": ("1", "rotation of the arm per rotation of the carrier, relative to it"),
    "x_S": ("m", "tip, x"),
    "y_S": ("m", "tip, y"),
    "vx_S": ("m/s", "velocity of the tip, x"),
    "vy_S": ("m/s", "velocity of the tip, y"),
    "L3": ("m", "distance of the tip from the sun's centre"),
    "x_M1": ("m", "intermediate axis, x"),
    "y_M1": ("m", "intermediate axis, y"),
    "x_O1": ("m", "planet's axis, x"),
    "y_O1": ("m", "planet's axis, y"),
    "along": ("m", "depth of the tip in the cell, along its axis"),
    "across": ("m", "tip beside the axis of the cell, to the left"),
}
GEARS = {
    "R1": ("m", "pitch radius of the sun at the contact"),
    "R2": ("m", "pitch radius of the intermediate gear at the contact"),
    "kappa1": ("1/m", "curvature of the sun's pitch curve, positive if convex"),
    "kappa2": ("1/m", "curvature of the intermediate gear's pitch curve, positive if convex"),
    "epsilon": ("1", "contact ratio of the non-circular pair"),
    "beta": ("rad", "helix angle of the helical pair"),
    "epsilon_h": ("1", "contact ratio of the helical pair"),
}
"""Quantities of the gears; where no teeth mesh, they are those of the end of the teeth that is
nearer.
"""
VECTORS = {"v_S": ("vx_S", "vy_S")}
HOISTED = ("beta", "epsilon_h", "beta1", "a1")
"""What of the carrier and its helical pair no angle changes."""
CHECKED = 720
"""Angles on the teeth at which their contact ratio must exist, so that it is a quantity."""


def takes(source: str) -> bool:
    """Return whether a source is a pick-up's file, points of its tip's path, or the name of a
    built-in one.
    """
    if not file.is_points(source):
        return examples.belongs_to_package(source, "pickup", {"helical_stage", "tray"})
    try:
        csv_rows.read_table(examples.read_source(source, "pickup", ".csv"), source, HEADER)
    except InputError:
        return False
    return True


def load(source: str, changes: Mapping[str, float]) -> Machine:
    """Return the machine of a pick-up; raises InputError and GeometryError as its file and train
    do.
    """
    return build_machine(file.load_pickup(source, changes))


def build_machine(machine: file.Pickup, train: PickupTrain | None = None) -> Machine:
    """Return a pick-up with its train as a machine: its values are the numbers that its motion and
    gears depend on.

    The law of a path, and the bars that the path has, do not change with the values. Raises
    GeometryError for a pick-up that has no train.
    """
    train = train or build_train(machine)
    fixed = {"L1": train.geometry.L1, "L2": train.geometry.L2, "phi5_far": train.phi5_far}
    fixed["transition"] = train.law.transition
    written, sidecar = machine.numbers(), load_formulas(MODEL).sidecar
    entries = STAGES | LAW
    if not train.law.transition:
        del entries["transition"]
    names = [
        name for name, (_, _, path) in entries.items() if path in written or (name == "transition")
    ]
    values = tuple(Value(name, *entries[name]) for name in names)
    data = [
        machine.si(value.path) if value.path in written else fixed[value.name] for value in values
    ]
    d, t, h = ca.SX.sym("d", len(values)), ca.SX.sym("t"), ca.SX.sym("h", len(HOISTED))
    values_by_name: dict[str, Any] = fixed | dict(zip(names, ca.vertsplit(d), strict=True))
    carrier = load_formulas(MODEL).composed("carrier", values_by_name)
    values_by_name |= dict(zip(HOISTED, ca.vertsplit(h), strict=True))
    law = _compose_law(train, values_by_name)
    results = _compose_motion(t, law, values_by_name) | _compose_gears(t, law, values_by_name)
    if not np.isfinite(train.contact_ratio(train.samples(CHECKED))).all():
        del results["epsilon"]
    return build_closed_machine(
        machine,
        build_machine,
        sidecar,
        values,
        np.array(data),
        {name: entry for name, entry in (MOTION | GEARS).items() if name in results},
        results,
        (t, d, h),
        ca.vertcat(*(carrier[name] for name in HOISTED)),
        [
            (t - joint.angle, {"name": joint.name, "order": joint.order, "period": TURN})
            for joint in law.joints
        ],
        SPEED,
        machine.measure_limits,
        VECTORS,
    )


class _Joint(NamedTuple):
    """An angle at which a law changes, and the derivative of the tip's place that jumps there, less
    one.
    """

    name: str
    angle: Any
    order: int


class _LawGraph(NamedTuple):
    """A law: `at` t -> the arm's angle and the slope with two derivatives (4,), the dwell, the
    teeth, the joints.

    `dwell` are its first and last angle, if there is one, and `teeth` the first and last angle at
    which teeth mesh.
    """

    at: Callable[[Any], ca.SX]
    dwell: tuple[Any, Any] | None
    teeth: tuple[Any, Any]
    joints: tuple[_Joint, ...]


def _compose_law(train: PickupTrain, inputs: Mapping[str, Any]) -> _LawGraph:
    """Return the graph of a train's law, whose numbers are `known` by name."""
    if isinstance(train.law, SplineLaw):
        return _compose_spline_law(train.law, train.toothed)
    start, end, width = inputs["dwell_start"], inputs["dwell_end"], inputs["transition"]
    joints = [_Joint("start of the dwell", start, 0), _Joint("end of the dwell", end, 0)]
    if not train.law.transition:
        law = ca.vertcat(inputs["p"], start, end, np.pi)
        function = load_formulas(MODEL).function("law")
        return _LawGraph(
            lambda t: function(t, law), (start, end), (end - TURN, start), tuple(joints)
        )
    smooth = ca.vertcat(inputs["p"], start, end, np.pi, width)
    joints = [joint._replace(order=2) for joint in joints]
    joints += [
        _Joint("end of the teeth", start - width, 1),
        _Joint("start of the teeth", end + width, 1),
    ]
    teeth = end - TURN + width, start - width
    return _LawGraph(lambda t: compose_smooth_law(t, smooth), (start, end), teeth, tuple(joints))


def _compose_spline_law(law: SplineLaw, teeth: tuple[float, float]) -> _LawGraph:
    """Return the graph of a law by its spline, with the numbers that the spline has now."""
    pieces = scipy.interpolate.PPoly.from_spline((law.lead.t, law.lead.c, law.lead.k))
    chosen = np.flatnonzero(np.diff(pieces.x) > 0)
    knots, coefficients = pieces.x[chosen], pieces.c[:, chosen]
    first, last = toothed_range(law.dwell)
    base = float(law.lead.t[law.lead.k]) if law.dwell is None else first

    def evaluate(t: Any) -> ca.SX:
        turned = TURN * ca.floor((t - base) / TURN)
        folded_angle = t - turned
        place = folded_angle if law.dwell is None else ca.fmin(folded_angle, last)
        derivatives = compose_pieces(place, knots, coefficients, 4)
        angle = derivatives[0] + place
        if law.dwell is not None:
            angle = ca.if_else(folded_angle <= last, angle, law.dwell_angle)
        return ca.vertcat(angle + turned, derivatives[1] + 1, *derivatives[2:])

    if law.dwell is None:
        return _LawGraph(evaluate, None, teeth, ())
    names = ("start of the dwell", "end of the dwell")
    joints = tuple(
        _Joint(*joint, 0) for joint in zip(names, (law.dwell.start, law.dwell.end), strict=True)
    )
    if teeth != (first, last):
        joints += (
            _Joint("end of the teeth", teeth[1], 1),
            _Joint("start of the teeth", teeth[0], 1),
        )
    return _LawGraph(evaluate, (law.dwell.start, law.dwell.end), teeth, joints)


def _compose_motion(t: ca.SX, law: _LawGraph, inputs: Mapping[str, Any]) -> dict[str, ca.SX]:
    """Return the quantities of `MOTION` by name."""
    model, far = load_formulas(MODEL), inputs["phi5_far"]

    def move(angle: Any) -> dict[str, Any]:
        arm, slope = ca.vertsplit(law.at(angle))[:2]
        if law.dwell is not None:
            start, end = law.dwell
            inside = angle - start + ROUNDING
            inside -= TURN * ca.floor(inside / TURN)
            slope = ca.if_else(inside <= end - start + 2 * ROUNDING, 0, slope)
        turned = {"phi1": arm, "g": slope, "phi5": far + angle}
        return (
            turned
            | model.composed("motion", {**inputs, **turned})
            | {"arm": far + angle + np.pi - arm}
        )

    moved, bottom = move(t), move(ca.SX(0))
    picked = {
        "x_bottom": bottom["x_S"],
        "y_bottom": bottom["y_S"],
        "axis": bottom["arm"] + inputs["mounting"],
    }
    entered = model.composed("entry", moved | picked)
    return moved | entered | {"along": entered["along"] + inputs["entry"]}


def _compose_gears(t: ca.SX, law: _LawGraph, inputs: Mapping[str, Any]) -> dict[str, ca.SX]:
    """Return the quantities of `GEARS` by name."""
    first, last = law.teeth
    folded_angle = t - TURN * ca.floor((t - first) / TURN)
    place = ca.if_else(folded_angle > (last + first + TURN) / 2, first, ca.fmin(folded_angle, last))
    arm, *slopes = ca.vertsplit(law.at(place))
    turned = {"g": slopes[0], "dg": slopes[1], "ddg": slopes[2], "phi5": place, "phi2": arm - np.pi}
    pitch = load_formulas(MODEL).composed("pitch", {**inputs, **turned})
    meshing = TEETH.composed("contact_ratio", {**inputs, **pitch})
    return {name: {**inputs, **pitch, **meshing}[name] for name in GEARS}
