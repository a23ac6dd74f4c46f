"""Friction of a planting device's gear teeth: along the flanks at the points of contact, against
the sliding.

The forces are those of the derived model `planting_lifted` at the pressure angle of the teeth. All
is rigid and without backlash, so that the contacts are those of the exact flanks, and the flank
that pushes carries the load.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from planter.engine.solvers import response
from planter.files import units
from planter.gears.geometry.cutting import ToothedPair
from planter.gears.geometry.mesh import SIDES, BearingPairs, SharedLoad, find_changes
from planter.gears.geometry.pitch_curves import POLAR
from planter.gears.results import (
    KINDS,
    Friction,
    FrictionCurves,
    FrictionTurn,
    PartExtent,
)
from planter.kernels import Array
from planter.numerics import piecewise
from planter.numerics.arrays import TURN
from planter.papers.planting.lifted import JOINTS, TOTALS, LiftedCycle, LiftedModel, Lifting
from planter.papers.planting.model import Device
from planter.papers.planting.results import Statistics

NODES = 3
"""Nodes of a panel between neighbouring jumps."""
LONGEST = np.radians(2)
"""Longer panels are cut."""
ASIDE = 1e-8
"""How far from a jump its sides are looked at [rad]; jumps closer than ten times that are one."""


@dataclass(frozen=True)
class Angles:
    """Carrier angles (n,) [rad] of a turn, its second half as its first, with weights of means over
    the turn.
    """

    phi: Array
    weights: Array

    @classmethod
    def from_jumps(cls, jumps: Array) -> Angles:
        """Between jumps (m,) of either of two sides that are half a turn distinct."""
        folded = np.unique(np.mod(jumps, np.pi))
        distinct = folded[np.diff(folded, append=folded[0] + np.pi) > 10 * ASIDE]
        ends = np.append(distinct, distinct[0] + np.pi)
        pieces = np.ceil(np.diff(ends) / LONGEST).astype(int)
        inner = [
            np.linspace(a, b, k, endpoint=False)
            for a, b, k in zip(ends[:-1], ends[1:], pieces, strict=True)
        ]
        cut = np.append(np.concatenate(inner), ends[-1])
        nodes, weights = piecewise.gauss_panels(cut, NODES)
        sides = cut[:-1, None] + ASIDE, cut[1:, None] - ASIDE
        half, none = np.hstack([sides[0], nodes, sides[1]]).ravel(), np.zeros((len(nodes), 1))
        panel_weights = np.hstack([none, weights, none]).ravel()
        return cls(np.concatenate([half, half + np.pi]), np.tile(panel_weights, 2) / (2 * np.pi))

    def mean(self, values: Array) -> float:
        """Return the mean over a cycle of values (n,) at the angles."""
        return float(self.weights @ values)


MESHES = "PQ"
FLANKS = ("plus", "minus")
"""Flanks as the model names them, in the order of `mesh.SIDES`."""
FRICTION, PRESSURE = "contact.tooth_friction_angle_deg", "contact.pressure_angle_deg"
_DENSE = np.linspace(0, TURN, 2881)
"""Angles between which the angle of a contact is looked for."""
_CORRECTIONS = 2


class ToothedTurn:
    """A device with teeth on both stages at a design (p,) [SI], over a turn."""

    def __init__(self, device: Device, x: Array, stages: Sequence[ToothedPair]) -> None:
        self.device, self.x, self.stages = device, x, stages
        self._model = LiftedModel(device, x)
        self._pressure = {PRESSURE: stages[0].order.pressure_angle}

    @cached_property
    def angles(self) -> Angles:
        """Angles between which no pair of teeth that bears comes, goes or passes the pitch point,
        and nothing else jumps.
        """
        breakpoints = response.find_breakpoints(
            self.device.force, self.device.prologue(self.x)
        ).angles
        return Angles.from_jumps(np.concatenate([breakpoints, *self._changes()]))

    def _changes(self) -> Iterator[Array]:
        """Angles (m,) at which pairs of teeth that bear come, go, and pass the pitch point, of each
        stage.
        """
        dense = self._model.turn(_DENSE).one
        for k, (tag, stage) in enumerate(zip(MESHES, self.stages, strict=True), 1):
            mesh, t = stage.mesh, f"t{k}"
            at, side = find_changes(mesh)
            sense = mesh.pair.sense
            polar = sense * mesh.gear.curve.at(sense * at)[POLAR]
            start = dense[t][0]
            target = start + np.mod(polar - start, TURN)
            phi = np.interp(target, dense[t], _DENSE)
            slope = np.interp(target, dense[t], np.gradient(_DENSE, dense[t]))
            for _ in range(_CORRECTIONS):
                phi += (target - self._model.turn(phi).one[t]) * slope
            pushing = np.where(self._model.turn(phi).one[f"M_{tag}"] >= 0, *SIDES)
            yield phi[side == pushing]

    def turn(
        self,
        lifted: Lifting | None = None,
        friction: float | None = None,
        behind: Lifting | None = None,
    ) -> LiftedCycle:
        """A turn with values of what is lifted, and with another angle of friction [rad] than the
        machine's.
        """
        changes = self._pressure | ({} if friction is None else {FRICTION: friction})
        return self._model.turn(self.angles.phi, lifted, changes, behind)

    @cached_property
    def without(self) -> LiftedCycle:
        """No friction between the teeth."""
        return self.turn(friction=0.0)

    @cached_property
    def bearings(self) -> tuple[BearingPairs, ...]:
        """The pairs of teeth in contact at P and at Q."""
        return tuple(
            BearingPairs.from_mesh(stage.mesh, stage.mesh.rolled(self.without.one[f"t{k}"]))
            for k, stage in enumerate(self.stages, 1)
        )

    def evaluate_sliding(
        self, loads: Sequence[SharedLoad], friction: float | None = None
    ) -> LiftedCycle:
        """Friction against the sliding, with loads that are shared out at P and at Q."""
        return self.turn(self.compute_lifting(loads), friction)

    def compute_lifting(self, loads: Sequence[SharedLoad]) -> Lifting:
        """Return the model's inputs for loads that are shared out at P and at Q."""
        values: dict[str, Array | float] = {"against": 1.0}
        for tag, load in zip(MESHES, loads, strict=True):
            for k, flank in enumerate(FLANKS):
                values |= {f"lead_{tag}_{flank}": load.lead[k], f"away_{tag}_{flank}": load.away[k]}
        return values

    @cached_property
    def shared(self) -> LiftedCycle:
        """Friction against the sliding, all pairs in contact bearing the same."""
        return self.evaluate_sliding(self.equal)

    @cached_property
    def equal(self) -> list[SharedLoad]:
        """All pairs in contact bear the same."""
        return [mesh.equal for mesh in self.bearings]


FORCES = {
    "F_A1": "size of the carrier's force on the middle shaft",
    "F_B1": "size of the carrier's force on the planet's shaft, across it",
    "F_O": "size of the frame's force on the sun",
    "F_O1": "size of the force of the sun's shaft on the carrier, across it",
}
TORQUES = {"M_L": "torque of the motor on the carrier"}
LOSSES = {
    "F_P_loss": "power lost between the teeth of sun and gear 5, side 1",
    "F_Q_loss": "power lost between the teeth of gear 6 and planet, side 1",
}


UNITS = ((FORCES, "N"), (TORQUES, "N m"), (LOSSES, "W"))
FRICTION_NAMES = {
    units.display_key(name, unit): meaning
    for names, unit in UNITS
    for name, meaning in names.items()
}
"""Meanings of all quantities by key."""


NORMAL = ("F_E", *(f"F_N{tag}" for tag in MESHES))
"""Contact forces of side 1 that are told beside those of the joints: the cam's, and the teeth's
normal forces.
"""
LOST = {"stage 1": "F_P_loss", "stage 2": "F_Q_loss", "cams": "F_E_loss"}


def compute_friction(device: Device, x: Array, stages: Sequence[ToothedPair]) -> FrictionCurves:
    """Return the effects of tooth friction in both stages on a device at a design (p,) [SI]."""
    teeth = ToothedTurn(device, x, stages)
    bearings = teeth.bearings
    turns = {
        "without": teeth.without,
        "convention": teeth.turn(),
        "sliding": teeth.shared,
        "nearest": teeth.evaluate_sliding([mesh.nearest for mesh in bearings]),
        "farthest": teeth.evaluate_sliding([mesh.farthest for mesh in bearings]),
    }
    support = [turn.totals["F_support"] for turn in turns.values()]
    sampled = Statistics.of_samples(device.support(device.prologue(x), device.engine.list_angles()))
    friction = Friction(
        friction_angle_deg=float(np.degrees(device.machine.si(FRICTION))),
        pressure_angle_deg=float(np.degrees(stages[0].order.pressure_angle)),
        angles=len(teeth.angles.phi),
        pairs=[mesh.pairs for mesh in bearings],
        objective=device.machine.objective.value(sampled.range_N, sampled.variance_N2),
        support_changed_N=float(np.abs(support - support[0]).max()),
        **{kind: summarise_turn(teeth, turn) for kind, turn in turns.items()},
        at_most_N=compute_maximum_forces(teeth),
    )
    phi = np.mod(teeth.angles.phi, TURN)
    order = np.argsort(phi)
    curves = _curves({kind: turns[kind] for kind in KINDS})
    ordered = {
        key: {kind: row[order] for kind, row in kinds.items()} for key, kinds in curves.items()
    }
    return FrictionCurves(friction, np.degrees(phi[order]), ordered, FRICTION_NAMES)


def summarise_turn(teeth: ToothedTurn, turn: LiftedCycle) -> FrictionTurn:
    """Return the figures of a cycle."""
    mean, per_turn = teeth.angles.mean, TURN / teeth.device.machine.si("operation.speed_rpm")
    torque, sizes = (
        turn.totals["M_L"],
        {name: np.abs(_row(turn, name)) for name in (*JOINTS, *NORMAL)},
    )
    return FrictionTurn(
        largest_N={name: float(size.max()) for name, size in sizes.items()},
        rms_N={name: float(np.sqrt(mean(size**2))) for name, size in sizes.items()},
        torque_Nm=PartExtent(float(torque.min()), float(torque.max())),
        motor_work_J=TURN * mean(torque),
        lost_J={
            place: per_turn * mean(turn.one[name] + turn.two[name]) for place, name in LOST.items()
        },
        efficiency=[
            1 - mean(turn.one[f"F_{tag}_loss"]) / mean(_input_power(turn, tag)) for tag in MESHES
        ],
    )


def compute_maximum_forces(teeth: ToothedTurn) -> dict[str, float]:
    """Bounds of the forces over all ways to share the loads of all meshes at all angles [N].

    A force is a quotient of linear functions in the shares of each mesh, so that its size is
    largest where at each mesh a single pair bears all.
    """
    first, second = teeth.bearings
    pairs = [
        [first.alone(i), second.alone(j)] for i in range(first.pairs) for j in range(second.pairs)
    ]
    equal = teeth.compute_lifting(teeth.equal)
    alone = [teeth.turn(teeth.compute_lifting(loads), behind=equal) for loads in pairs]
    bounds = {
        name: max(float(np.abs(_row(turn, name)).max()) for turn in alone)
        for name in (*JOINTS, *NORMAL)
    }
    return bounds | {
        name: _bound_shared_force(teeth.shared, alone, name) for name in JOINTS if name in TOTALS
    }


def _bound_shared_force(shared: LiftedCycle, alone: Sequence[LiftedCycle], name: str) -> float:
    """The largest size of a force that both sides add up to, each with any single pair of teeth at
    each mesh.
    """
    base = _vector(shared, name)
    more = [_vector(turn, name) - base for turn in alone]
    behind = [np.roll(part, base.shape[1] // 2, axis=1) for part in more]
    return max(
        float(np.hypot(*(base + first + second)).max()) for first in more for second in behind
    )


def _input_power(turn: LiftedCycle, tag: str) -> Array:
    """Power (n,) that a mesh is given, by the inner gear or by the outer one, seen from the carrier
    [W].
    """
    power, loss = turn.one[f"F_{tag}_power"], turn.one[f"F_{tag}_loss"]
    return np.asarray(np.maximum(power + loss, 0) + np.maximum(-power, 0))


def _curves(turns: Mapping[str, LiftedCycle]) -> dict[str, dict[str, Array]]:
    """Quantities over a turn by key, each by kind of friction."""
    curves = {}
    for names, unit in UNITS:
        for name in names:
            rows = {kind: _row(turn, name) for kind, turn in turns.items()}
            curves[units.display_key(name, unit)] = rows
    return curves


def _row(turn: LiftedCycle, name: str) -> Array:
    """The size (n,) of the force in a joint [N], or another quantity of side 1 or of both."""
    if name in JOINTS:
        return turn.joint(name)
    return (turn.totals if name in turn.totals else turn.one)[name]


def _vector(turn: LiftedCycle, name: str) -> Array:
    """The force in a joint (2, n) [N]."""
    source = turn.totals if name in TOTALS else turn.one
    return np.array([source[part] for part in JOINTS[name]])
