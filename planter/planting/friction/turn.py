"""A turn of a planting device with teeth: which pairs bear at each angle, and the forces with any friction of theirs.

The forces are those of the derived model `planting_lifted` at the pressure angle of the teeth. All is rigid and without
play, so that the contacts are those of the exact flanks, and the flank that pushes bears.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property

import numpy as np

from planter.gear_geometry.cutting import ToothedPair
from planter.gear_geometry.mesh import SIDES, BearingPairs, SharedLoad, find_changes
from planter.gear_geometry.pitch_curves import POLAR
from planter.kernels import Array
from planter.numerics.arrays import TURN
from planter.optimise import joints
from planter.planting.friction.angles import Angles
from planter.planting.lifted import LiftedCycle, LiftedModel, Lifting
from planter.planting.model import Device

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
        """Angles between which no pair of teeth that bears comes, goes or passes the pitch point, and nothing else
        jumps."""
        own = joints.find(self.device.force, self.device.prologue(self.x)).angles
        return Angles.between(np.concatenate([own, *self._changes()]))

    def _changes(self) -> Iterator[Array]:
        """Angles (m,) at which pairs of teeth that bear come, go, and pass the pitch point, of each stage."""
        dense = self._model.turn(_DENSE).one
        for k, (tag, stage) in enumerate(zip(MESHES, self.stages, strict=True), 1):
            mesh, t = stage.mesh, f"t{k}"
            at, side = find_changes(mesh)
            sense = mesh.pair.sense
            polar = sense * mesh.gear.curve.at(sense * at)[POLAR]
            start = dense[t][0]
            wanted = start + np.mod(polar - start, TURN)
            phi = np.interp(wanted, dense[t], _DENSE)
            slope = np.interp(wanted, dense[t], np.gradient(_DENSE, dense[t]))
            for _ in range(_CORRECTIONS):
                phi += (wanted - self._model.turn(phi).one[t]) * slope
            pushing = np.where(self._model.turn(phi).one[f"M_{tag}"] >= 0, *SIDES)
            yield phi[side == pushing]

    def turn(
        self, lifted: Lifting | None = None, friction: float | None = None, behind: Lifting | None = None
    ) -> LiftedCycle:
        """A turn with values of what is lifted, and with another angle of friction [rad] than the machine's."""
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

    def sliding(self, loads: Sequence[SharedLoad], friction: float | None = None) -> LiftedCycle:
        """Friction against the sliding, with loads that are shared out at P and at Q."""
        return self.turn(self.lifting(loads), friction)

    def lifting(self, loads: Sequence[SharedLoad]) -> Lifting:
        """What the model takes of loads that are shared out at P and at Q."""
        told: dict[str, Array | float] = {"against": 1.0}
        for tag, load in zip(MESHES, loads, strict=True):
            for k, flank in enumerate(FLANKS):
                told |= {f"lead_{tag}_{flank}": load.lead[k], f"away_{tag}_{flank}": load.away[k]}
        return told

    @cached_property
    def shared(self) -> LiftedCycle:
        """Friction against the sliding, all pairs in contact bearing the same."""
        return self.sliding(self.equal)

    @cached_property
    def equal(self) -> list[SharedLoad]:
        """All pairs in contact bear the same."""
        return [one.equal for one in self.bearings]
