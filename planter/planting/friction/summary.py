"""What friction of the teeth does to a planting device: kinds of it beside each other, and ways to share a load."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from planter.files import units
from planter.gear_geometry.cutting import ToothedPair
from planter.gears.results import KINDS, Extent, Friction, FrictionCurves, FrictionTurn
from planter.kernels import Array
from planter.numerics.arrays import TURN
from planter.planting import cycle
from planter.planting.friction import shown
from planter.planting.friction.turn import FRICTION, MESHES, ToothedTurn
from planter.planting.lifted import JOINTS, TOTALS, LiftedCycle
from planter.planting.model import Device
from planter.planting.objective import read_weights

NORMAL = ("F_E", *(f"F_N{tag}" for tag in MESHES))
"""Contact forces of side 1 that are told beside those of the joints: the cam's, and the teeth's normal forces."""
LOST = {"stage 1": "F_P_loss", "stage 2": "F_Q_loss", "cams": "F_E_loss"}


def rubbing(device: Device, x: Array, stages: Sequence[ToothedPair]) -> FrictionCurves:
    """What friction of the teeth of both stages does to a device at a design (p,) [SI]."""
    teeth = ToothedTurn(device, x, stages)
    bearings = teeth.bearings
    turns = {
        "without": teeth.without,
        "convention": teeth.turn(),
        "sliding": teeth.shared,
        "nearest": teeth.sliding([one.nearest for one in bearings]),
        "farthest": teeth.sliding([one.farthest for one in bearings]),
    }
    support = [turn.totals["F_support"] for turn in turns.values()]
    sampled = cycle.compute_statistics(
        device.support(device.prologue(x), cycle.sample_angles(device.machine.objective.samples))
    )
    found = Friction(
        friction_angle_deg=float(np.degrees(device.machine.si(FRICTION))),
        pressure_angle_deg=float(np.degrees(stages[0].order.pressure_angle)),
        angles=len(teeth.angles.phi),
        pairs=[one.pairs for one in bearings],
        objective=read_weights(device.machine).value(sampled.range_N, sampled.variance_N2),
        support_changed_N=float(np.abs(support - support[0]).max()),
        **{kind: told(teeth, turn) for kind, turn in turns.items()},
        at_most_N=at_most(teeth),
    )
    phi = np.mod(teeth.angles.phi, TURN)
    order = np.argsort(phi)
    curves = _curves({kind: turns[kind] for kind in KINDS})
    ordered = {key: {kind: row[order] for kind, row in kinds.items()} for key, kinds in curves.items()}
    return FrictionCurves(found, np.degrees(phi[order]), ordered)


def told(teeth: ToothedTurn, turn: LiftedCycle) -> FrictionTurn:
    """A turn in numbers."""
    mean, per_turn = teeth.angles.mean, TURN / teeth.device.machine.si("operation.speed_rpm")
    torque, sizes = turn.totals["M_L"], {name: _size(turn, name) for name in (*JOINTS, *NORMAL)}
    return FrictionTurn(
        largest_N={name: float(size.max()) for name, size in sizes.items()},
        rms_N={name: float(np.sqrt(mean(size**2))) for name, size in sizes.items()},
        torque_Nm=Extent(float(torque.min()), float(torque.max())),
        motor_work_J=TURN * mean(torque),
        lost_J={place: per_turn * mean(turn.one[name] + turn.two[name]) for place, name in LOST.items()},
        efficiency=[1 - mean(turn.one[f"F_{tag}_loss"]) / mean(_given(turn, tag)) for tag in MESHES],
    )


def at_most(teeth: ToothedTurn) -> dict[str, float]:
    """Bounds of the forces over all ways to share the loads of all meshes at all angles [N].

    A force is a quotient of linear functions in the shares of each mesh, so that its size is largest where at each mesh
    a single pair bears all.
    """
    one, two = teeth.bearings
    pairs = [[one.alone(i), two.alone(j)] for i in range(one.pairs) for j in range(two.pairs)]
    equal = teeth.lifting(teeth.equal)
    alone = [teeth.turn(teeth.lifting(loads), behind=equal) for loads in pairs]
    found = {name: max(float(_size(turn, name).max()) for turn in alone) for name in (*JOINTS, *NORMAL)}
    return found | {name: _of_both(teeth.shared, alone, name) for name in JOINTS if name in TOTALS}


def _of_both(shared: LiftedCycle, alone: Sequence[LiftedCycle], name: str) -> float:
    """The largest size of a force that both sides add up to, each with any pair of its own alone at each mesh."""
    base = _vector(shared, name)
    more = [_vector(turn, name) - base for turn in alone]
    behind = [np.roll(part, base.shape[1] // 2, axis=1) for part in more]
    return max(float(np.hypot(*(base + own + other)).max()) for own in more for other in behind)


def _given(turn: LiftedCycle, tag: str) -> Array:
    """Power (n,) that a mesh is given, by the inner gear or by the outer one, seen from the carrier [W]."""
    power, loss = turn.one[f"F_{tag}_power"], turn.one[f"F_{tag}_loss"]
    return np.asarray(np.maximum(power + loss, 0) + np.maximum(-power, 0))


def _curves(turns: Mapping[str, LiftedCycle]) -> dict[str, dict[str, Array]]:
    """Quantities over a turn by key, each by kind of friction."""
    joints = {units.key(name, "N"): {kind: turn.joint(name) for kind, turn in turns.items()} for name in shown.JOINTS}
    torques = {
        units.key(name, "N m"): {kind: turn.totals[name] for kind, turn in turns.items()} for name in shown.TORQUES
    }
    losses = {units.key(name, "W"): {kind: turn.one[name] for kind, turn in turns.items()} for name in shown.LOSSES}
    return joints | torques | losses


def _vector(turn: LiftedCycle, name: str) -> Array:
    """The force in a joint (2, n) [N]."""
    source = turn.totals if name in TOTALS else turn.one
    return np.array([source[part] for part in JOINTS[name]])


def _size(turn: LiftedCycle, name: str) -> Array:
    """Size (n,) of the force in a joint or a contact [N]."""
    return turn.joint(name) if name in JOINTS else np.abs(turn.one[name])
