"""A second derivation of the exact model, by Lagrange's equations and virtual power, to 40 digits
and more.

The generated array code runs at 50 digits on random machines and designs; the motion comes from the
geometry alone.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest
from mpmath import mp

from planter.papers.planting.file import PlantingMachine
from tests.support import kinematics, machines, model, xp_mpmath
from tests.support.arithmetic import MPMATH, Number
from tests.support.lagrange import RELEASED, WHOLE, Objects, State

DIGITS, AGREEING, TERMS = 50, 40, (70, 0)
NAMES = (*machines.BUILT_IN, *machines.RANDOM)
TEETH = (("P", "sun", "middle"), ("Q", "middle", "planet"))


@pytest.fixture(autouse=True)
def _digits() -> Iterator[None]:
    with mp.workdps(DIGITS):
        yield


def _vector(*components: Number) -> Objects:
    return np.array([*components, *[mp.zero] * (3 - len(components))], dtype=object)


@dataclass(frozen=True)
class Side:
    """Lagrange's equations of one side at one angle, and the forces that fulfil them."""

    device: kinematics.Device
    motion: kinematics.Side

    @property
    def state(self) -> State:
        jets = [self.motion.phi, self.motion.phi52, self.motion.phi72, self.motion.theta1]
        values, rates, accelerations = ([jet.parts[order] for jet in jets] for order in range(3))
        lengths = (
            self.device.sun.distance,
            self.device.gear6.distance,
            self.device["design.gamma_deg"],
            self.device["design.theta_deg"],
            *self.device.vector("nozzle.hinge_A_mm"),
        )
        return State(values, rates, accelerations, lengths)

    def inertia(self) -> Objects:
        """Generalised inertia forces and weights of all bodies of the side."""
        d, g, state = self.device, self.device["gravity_m_s2"], self.state
        radius, angle = d["centroid.middle_radius_mm"], d["centroid.middle_angle_deg"]
        x, y = d["planet_xy_mm[0]"], d["planet_xy_mm[1]"]
        middle = d["J56_about_A1_kg_m2"] - d["middle_kg"] * radius**2
        planet = d["J7_about_B1_kg_m2"] - d["planet_kg"] * (x**2 + y**2)
        polar = (radius * mp.cos(angle), radius * mp.sin(angle), 0)
        total = state.inertia("middle", polar, (d["middle_kg"], g, 1, 1, middle))
        total = total + state.inertia("planet", (x, y, 0), (d["planet_kg"], g, 1, 1, planet))
        return total + self._half("inner", 1) + self._half("outer", -1)

    def _half(self, name: str, mirrored: int) -> Objects:
        d, total = self.device, mp.zero
        for part in ("C1", "C2"):
            x, y, z = d.vector(f"nozzle.{part}_mm")
            moments = d.vector(f"inertia.{part}_centroidal_xx_yy_zz_kg_m2")
            properties = (d[f"mass.half_{part}_kg"], d["gravity_m_s2"], *moments)
            total = total + self.state.inertia(name, (x, y, mirrored * z), properties)
        return total

    def spring(self) -> Objects:
        origin, turned = self.state.frame("inner")
        hook = origin + turned @ _vector(*self.device.vector("nozzle.hook_F_mm"))
        return self.motion.spring * self.state.power(
            "inner", "outer", hook, _vector(mp.zero, mp.zero, mp.one)
        )

    def unknowns(self, flanks: tuple[int, int]) -> dict[str, Objects]:
        """Virtual power of each unknown force per unit of its size."""
        state = self.state
        (x, z), (origin, axes) = self.motion.cam_direction, state.frame("planet")
        roller = origin + axes @ _vector(*(c.value for c in self.motion.roller))
        forces = {"F_E": state.power("inner", "carrier", roller, axes @ _vector(x, mp.zero, z))}
        for stage, flank in enumerate(flanks, 1):
            mesh, (tooth, inner, outer) = self.motion.mesh(stage), TEETH[stage - 1]
            forces[f"F_{tooth}"] = state.power(
                inner, outer, _vector(*mesh.place), _vector(*mesh.direction(flank))
            )
        for shaft, name in (("A1", "middle"), ("B1", "planet")):
            at = state.frame(name)[0]
            for axis, unit in zip("xy", (_vector(mp.one), _vector(mp.zero, mp.one)), strict=True):
                forces[f"F_{shaft}{axis}"] = state.power(name, "carrier", at, unit)
        return forces

    def solve(self) -> dict[str, Number]:
        """Sizes of the unknown forces, each on the flank that pushes; then what is left for the
        whole device.
        """
        required, flanks = self.inertia() - self.spring(), (1, 1)
        for _ in range(3):
            powers = self.unknowns(flanks)
            matrix = mp.matrix(np.array(list(powers.values())).T[RELEASED].tolist())
            sizes = dict(
                zip(
                    powers, mp.lu_solve(matrix, mp.matrix(required[RELEASED].tolist())), strict=True
                )
            )
            pulls = [tooth for tooth in ("F_P", "F_Q") if sizes[tooth] < 0]
            if not pulls:
                break
            flanks = (-flanks[0], flanks[1]) if "F_Q" not in pulls else (flanks[0], -flanks[1])
        left = required - sum(size * powers[name] for name, size in sizes.items())
        solution = {name: left[i] for name, i in WHOLE.items()}
        return {**sizes, **solution, **self._teeth(sizes, flanks)}

    def _teeth(self, sizes: dict[str, Number], flanks: tuple[int, int]) -> dict[str, Number]:
        teeth = {}
        for stage, flank in enumerate(flanks, 1):
            tooth = TEETH[stage - 1][0]
            for axis, component in zip("xy", self.motion.mesh(stage).direction(flank), strict=True):
                teeth[f"F_{tooth}{axis}"] = sizes[f"F_{tooth}"] * component
        return teeth


SIDE = ("F_E", "F_Px", "F_Py", "F_Qx", "F_Qy", "F_A1x", "F_A1y", "F_B1x", "F_B1y")


def lagrange(
    machine: PlantingMachine, phi: Number
) -> tuple[list[dict[str, Number]], dict[str, Number]]:
    """Forces of both sides, and of the frame on the whole device."""
    device = kinematics.Device(machine, MPMATH)
    sides = [Side(device, device.side(angle)).solve() for angle in (phi, phi - mp.pi)]
    totals = {name: sides[0][name] + sides[1][name] for name in WHOLE}
    totals["F_support"] += (device["sun_kg"] + device["carrier_kg"]) * device["gravity_m_s2"]
    return sides, totals


@cache
def angle(name: str) -> float:
    return float(np.random.default_rng(NAMES.index(name)).uniform(0, 2 * np.pi))


def generated(name: str, phi: Number) -> model.Outputs:
    device = machines.device(name)
    design, constants = (
        [mp.mpf(float(v)) for v in vector] for vector in (device.design, device.constants)
    )
    return model.ArrayModel(device, TERMS)(xp_mpmath, phi, design, constants)


def gaps(name: str, machine: PlantingMachine, phi: Number) -> dict[str, Number]:
    """Relative differences of the generated model to Lagrange's equations for a machine."""
    expected, actual = lagrange(machine, phi), generated(name, phi)
    pairs = {
        f"{key}, side {i + 1}": (expected[0][i][key], actual.sides[i][key])
        for i in (0, 1)
        for key in SIDE
    }
    pairs |= {key: (expected[1][key], actual.totals[key]) for key in WHOLE}
    return {
        key: abs(computed - reference) / max(1, abs(computed))
        for key, (computed, reference) in pairs.items()
    }


@pytest.mark.parametrize("name", machines.sampled(2))
def test_both_derivations_agree(name: str) -> None:
    for key, gap in gaps(name, machines.machine(name), mp.mpf(angle(name))).items():
        assert gap < mp.mpf(10) ** -AGREEING, key


def test_a_mass_off_by_a_billionth_shows() -> None:
    changed = machines.tampered("wang2017", "mass.planet_kg", 1 + 1e-9)
    differences = gaps("wang2017", changed, mp.mpf(1))
    assert differences["F_support"] > mp.mpf(10) ** -12
    assert differences["M_L"] > mp.mpf(10) ** -12
