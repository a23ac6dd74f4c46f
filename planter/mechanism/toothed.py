"""The toothed gears of a user-defined mechanism: every meshing pair of its statement, for
`planter gears`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
import scipy

from planter.engine.machine import load_driven_machine
from planter.errors import InputError
from planter.gears.gear_set import GearSet
from planter.gears.geometry.cutting import ToothedPair, cut_teeth
from planter.gears.geometry.pitch_curves import CurvePair, SampledRadius
from planter.gears.parts import PlacedGear
from planter.gears.request import GearOptions
from planter.kernels import Array
from planter.mechanism.file import MechanismFile
from planter.mechanism.model import Model
from planter.numerics.arrays import TURN, unit_vector, wrap_angle
from planter.report import files

SAMPLES = 360
"""Points of a pitch curve."""
MOST_TURNS = 24
"""Turns of the drive within which a gear must turn once against its line of centres."""
PITCH_TOLERANCE = 1e-5
"""Share of the distance of the axes by which pitch radii that roll on each other may miss it."""


class MechanismMesh:
    """A pair of meshing gears of a mechanism, over a revolution of the faster one against their
    line of centres.

    Raises InputError for gears that cannot have pitch curves with outer teeth: they stop or
    oscillate, their ratio is not an integer, or the distance of their axes is not constant.
    """

    def __init__(self, model: Model, tag: str, names: tuple[str, str]) -> None:
        self.model, self.tag, self.place = (
            model,
            tag,
            f"{model.machine.source}: mesh {tag} of {' and '.join(names)}",
        )
        turned = np.abs(self._polar(np.array([0.0, TURN])) @ [-1.0, 1.0])
        if not turned.all():
            raise InputError(
                f"{self.place}: a gear does not turn against the line of centres; no teeth are cut"
            )
        self.slow = int(np.argmin(turned))
        ratio = turned[1 - self.slow] / turned[self.slow]
        self.turns = round(ratio)
        if abs(ratio - self.turns) > PITCH_TOLERANCE:
            raise InputError(
                f"{self.place}: one gear turns {ratio:.6g} times in a turn of the other; pitch "
                f"curves close for a "
                "whole number of turns"
            )
        self.gear = 1 - self.slow
        self.names = names[self.gear], names[self.slow]

    def pair(self) -> CurvePair:
        """Return the pair of the faster gear, whose pitch curve is sampled, and its mate."""
        phi = self._turn()
        values = self._values(phi[:-1])
        polar, radius = values[f"polar_{self.gear + 1}"], values[f"r_{self.gear + 1}"]
        sense = 1 if polar[1] > polar[0] else -1
        if not (np.diff(sense * polar) > 0).all():
            raise InputError(
                f"{self.place}: {self.names[0]} oscillates against the line of centres"
            )
        sums = values["r_1"] + values["r_2"]
        if (
            not np.ptp(sums) <= PITCH_TOLERANCE * abs(sums[0])
            or min(values["r_1"].min(), values["r_2"].min()) <= 0
        ):
            raise InputError(
                f"{self.place}: radii that roll on each other add up to {sums.min() * 1e3:.6g} to "
                f"{sums.max() * 1e3:.6g} mm, but the distance of the axes must be constant; "
                f"correct the motion or the "
                "pitch radius"
            )
        pair = SampledRadius(sense * polar, radius, self.place, sense).build_pair(self.turns)
        if not abs(pair.distance - sums.mean()) <= PITCH_TOLERANCE * pair.distance:
            raise InputError(
                f"{self.place}: the mate closes at {pair.distance * 1e3:.6g} mm between the axes, "
                f"but they are "
                f"{sums.mean() * 1e3:.6g} mm apart"
            )
        return pair

    def place_gears(self, cut: ToothedPair) -> Iterator[PlacedGear]:
        """Yield both gears where they are at the start of the turn, their keyways along x of their
        frames.

        Where teeth ask for another size, the mechanism is as much larger about its origin.
        """
        start = {name: float(value[0]) for name, value in self._values(np.zeros(1)).items()}
        centre = np.array([start["x"], start["y"]]) * cut.sized.scale
        if self.gear == 0:
            centre -= cut.sized.pair.distance * unit_vector(start["line"])
        way = start["line"] + np.pi * self.gear
        for number, gear, (angle, shift, _) in zip(
            (self.gear, self.slow), cut.gears, cut.mesh.places(np.zeros(1)), strict=True
        ):
            turned = way + float(angle[0])
            x, y = centre + float(shift[0]) * unit_vector(way)
            key = start["line"] + np.pi * number - start[f"polar_{number + 1}"] - turned
            yield PlacedGear(gear, turned, (float(x), float(y)), float(wrap_angle(np.asarray(key))))

    def _turn(self) -> Array:
        """Return angles (n + 1,) [rad] of the drive over a turn of the faster gear against the line
        of centres.
        """
        start = self._polar(np.zeros(1))[self.gear, 0]

        def left(phi: float) -> float:
            return abs(float(self._polar(np.array([phi]))[self.gear, 0]) - start) - TURN

        end = next((TURN * k for k in range(1, MOST_TURNS + 1) if left(TURN * k) >= 0), None)
        if end is None:
            raise InputError(
                f"{self.place}: {self.names[0]} does not turn once in {MOST_TURNS} turns of the "
                f"drive"
            )
        return np.linspace(0, float(scipy.optimize.brentq(left, 0, end, xtol=1e-14)), SAMPLES + 1)

    def _polar(self, phi: Array) -> Array:
        values = self._values(phi)
        return np.array([values["polar_1"], values["polar_2"]])

    def _values(self, phi: Array) -> dict[str, Array]:
        start = f"mesh_{self.tag}_"
        return {
            name.removeprefix(start): row
            for name, row in self.model.evaluate("meshes", phi).items()
            if name.startswith(start)
        }


def cut_gears(source: str, options: GearOptions) -> GearSet:
    """Return the gears of every mesh.

    Raises InputError without a mesh, and as `MechanismMesh` and `cut_teeth` do.
    """
    machine = load_driven_machine(source, options.changes, options.speed_rpm)
    mechanism = machine.document
    assert isinstance(mechanism, MechanismFile)
    meshes = {tag: tuple(names) for tag, names in mechanism.model.sidecar.get("meshes", {}).items()}
    if not meshes:
        raise InputError(f"{mechanism.source}: its statement has no meshing gears")
    if options.counts and len(options.counts) != len(meshes):
        numbers = ",".join(map(str, options.counts))
        allowed = f"it must be the teeth of one gear of each mesh: {', '.join(meshes)}"
        raise InputError(f"--teeth {numbers}: {allowed}")
    model, pairs, placed = Model(machine), [], list[PlacedGear]()
    for number, (tag, names) in enumerate(meshes.items()):
        mesh = MechanismMesh(model, tag, _label_gears(names, tag, meshes))
        pairs.append(cut_teeth(mesh.pair(), options.order_pair(number), mesh.place, mesh.names))
        placed += mesh.place_gears(pairs[-1])
    provenance = files.list_provenance(mechanism)
    return GearSet(mechanism.name, options.order, placed, provenance, pairs)


def _label_gears(
    names: tuple[str, ...], tag: str, meshes: Mapping[str, tuple[str, ...]]
) -> tuple[str, str]:
    """Return the names of a mesh's gears, with the tag where a body has gears in several meshes."""
    all_names = [name for pair in meshes.values() for name in pair]
    inner, outer = (f"{name} {tag}" if all_names.count(name) > 1 else name for name in names)
    return inner, outer
