"""True tooth friction of a planting device: work, forces rebuilt from solved contacts, bounds over
all sharings.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from planter.gears.geometry.contacts import Contacts
from planter.gears.geometry.cutting import ToothOrder
from planter.gears.geometry.mesh import SIDES, BearingPairs, SharedLoad
from planter.kernels import Array
from planter.numerics.arrays import TURN
from planter.papers.planting import tooth_friction as summary
from planter.papers.planting import toothed
from planter.papers.planting.lifted import JOINTS, TOTALS, LiftedCycle, Lifting
from planter.papers.planting.model import Device
from planter.papers.planting.tooth_friction import FRICTION, MESHES, Angles, ToothedTurn
from tests.support import machines

ORDERS = {
    "wang2017": [ToothOrder(module=2e-3)] * 2,
    "random 1": [
        ToothOrder(teeth=41, pressure_angle=np.radians(25), allow_undercut=True, process="wire")
    ]
    * 2,
}


@cache
def cut_gears(name: str) -> ToothedTurn:
    device = machines.device(name)
    train = toothed.cut_gear_train(device, ORDERS[name])
    return ToothedTurn(device, train.x, train.stages)


def speed(teeth: ToothedTurn) -> float:
    return teeth.device.machine.si("operation.speed_rpm")


def lost(turn: LiftedCycle) -> Array:
    """Power that the teeth of both sides lose (n,) [W]."""
    return np.asarray(sum(side[f"F_{tag}_loss"] for side in (turn.one, turn.two) for tag in MESHES))


def unexplained(teeth: ToothedTurn, turn: LiftedCycle) -> float:
    """Power of the motor [W] that is neither that without friction nor lost at the teeth, at
    most.
    """
    more = (turn.totals["M_L"] - teeth.without.totals["M_L"]) * speed(teeth)
    return float(np.abs(more - lost(turn)).max())


@pytest.mark.parametrize("name", ORDERS)
def test_motor_work_equals_tooth_loss_at_every_angle(name: str) -> None:
    teeth = cut_gears(name)
    convention, sliding = teeth.turn(), teeth.shared
    assert unexplained(teeth, sliding) < 1e-11
    assert unexplained(teeth, convention) < 1e-11
    assert lost(convention) == pytest.approx(0, abs=0)
    assert lost(sliding).min() > 0
    cycle_summary = summary.summarise_turn(teeth, sliding)
    assert cycle_summary.motor_work_J == pytest.approx(sum(cycle_summary.lost_J.values()), rel=1e-7)
    assert cycle_summary.lost_J["stage 1"] > 0.01


def off(teeth: ToothedTurn, turn: LiftedCycle, stage: int) -> float:
    """How far a turn's forces [N], moments [N m] and losses [W] at a mesh are at most from those of
    solved contacts.

    They are put together from normal forces and friction of every pair, at the points where flanks
    touch, against how the flanks move there, at angles all round the turn.
    """
    tag = MESHES[stage]
    picked = np.flatnonzero(teeth.angles.weights)[7::61]
    sampled = {key: values[picked] for key, values in turn.one.items()}
    rates = {
        "sun": 0.0,
        "middle": speed(teeth) + sampled["F_P_power"] / sampled["M_P"],
        "planet": sampled["Omega"],
    }
    inner, outer = (("sun", "middle"), ("middle", "planet"))[stage]
    turning = np.broadcast_to(rates[inner] - rates[outer], len(picked))
    side = np.where(sampled[f"M_{tag}"] >= 0, *SIDES)
    friction = np.tan(teeth.device.machine.si(FRICTION))
    mesh = teeth.stages[stage].mesh
    gamma = teeth.x[teeth.device.names.index("gamma_deg")]
    line = teeth.angles.phi[picked] + np.pi / 2 + stage * gamma
    at = mesh.rolled(sampled[f"t{stage + 1}"])
    faced = mesh.facing(at)
    points = Contacts(mesh, faced).points
    worst = 0.0
    for k in range(len(picked)):
        radius = float(np.hypot(*mesh.gear.curve.at(mesh.pair.sense * at[k : k + 1])[:2])[0])
        corners = points[:, (faced.at == at[k]) & (faced.side == side[k])]
        arms = corners - np.array([[radius], [0.0]])
        normals = arms / np.hypot(*arms)
        normals = normals * -side[k] * np.sign(normals[1])
        velocities = turning[k] * np.array([-arms[1], arms[0]])
        each = sampled[f"F_N{tag}"][k] / corners.shape[1]
        forces = each * (normals - friction * velocities / np.hypot(*velocities))
        total = forces.sum(axis=1) @ np.array([1, 1j]) * np.exp(1j * line[k])
        from_outer = corners - np.array([[mesh.pair.distance], [0.0]])
        moment = from_outer[1] @ forces[0] - from_outer[0] @ forces[1]
        rubbed = friction * each * np.hypot(*velocities).sum()
        differences = (
            total - sampled[f"F_{tag}x"][k] - 1j * sampled[f"F_{tag}y"][k],
            moment - sampled[f"M_{tag}"][k],
            rubbed - sampled[f"F_{tag}_loss"][k],
        )
        worst = max(worst, *map(abs, differences))
    return worst


@pytest.mark.parametrize("name", ORDERS)
@pytest.mark.parametrize("stage", [0, 1])
def test_forces_and_losses_are_those_of_solved_contacts(name: str, stage: int) -> None:
    assert off(cut_gears(name), cut_gears(name).shared, stage) < 1e-9


def reversed_(lifting: Lifting, names: tuple[str, ...]) -> Lifting:
    return {name: -value if name.startswith(names) else value for name, value in lifting.items()}


def test_wrong_friction_direction_breaks_the_laws() -> None:
    teeth = cut_gears("wang2017")
    right = teeth.compute_lifting(teeth.equal)
    reversed_turn = teeth.turn(reversed_(right, ("lead", "away")))
    assert unexplained(teeth, reversed_turn) < 1e-11
    assert lost(reversed_turn).max() < 0
    assert off(teeth, reversed_turn, 0) > 1
    assert off(teeth, teeth.turn(reversed_(right, ("lead",))), 0) > 1
    assert (
        off(teeth, teeth.evaluate_sliding([bearing.nearest for bearing in teeth.bearings]), 0) > 0.1
    )
    assert off(teeth, teeth.turn(), 0) > 1


def test_without_friction_it_is_the_exact_model() -> None:
    teeth = cut_gears("random 1")
    machine = teeth.device.machine
    pressure = {
        "contact.pressure_angle_deg": float(np.degrees(teeth.stages[0].order.pressure_angle))
    }
    device = Device(machine.with_numbers({FRICTION: 0.0, **pressure}))
    exact = device.cycle(device.prologue(teeth.x), teeth.angles.phi)
    sliding_turn = teeth.evaluate_sliding(teeth.equal, friction=0.0)
    for vector, its, side in (
        ("side", "side1", sliding_turn.one),
        ("totals", "totals", sliding_turn.totals),
    ):
        for entry, row in zip(device.sidecar["vectors"][vector], exact[its], strict=True):
            assert side[entry["name"]] == pytest.approx(
                row, rel=1e-12, abs=1e-12 * max(1, np.abs(row).max())
            )
    assert teeth.shared.joint("F_A1") != pytest.approx(sliding_turn.joint("F_A1"), rel=1e-3)


def shared_at_random(bearing: BearingPairs, rng: np.random.Generator) -> SharedLoad:
    weights = np.where(
        np.isfinite(bearing.beyond), rng.exponential(size=bearing.beyond.shape) ** 2, 0.0
    )
    weights /= weights.sum(axis=1, keepdims=True)
    beyond = np.nan_to_num(bearing.beyond)
    return SharedLoad(
        (weights * np.sign(beyond)).sum(axis=1), (weights * np.abs(beyond)).sum(axis=1)
    )


@pytest.mark.parametrize("name", ORDERS)
def test_any_load_sharing_stays_within_reported_range(name: str) -> None:
    teeth, rng = cut_gears(name), np.random.default_rng(5)
    bounds = summary.compute_maximum_forces(teeth)
    near_range, far = (
        summary.summarise_turn(
            teeth, teeth.evaluate_sliding([getattr(bearing, contact) for bearing in teeth.bearings])
        )
        for contact in ("nearest", "farthest")
    )
    for _ in range(6):
        first, second = (
            teeth.compute_lifting([shared_at_random(bearing, rng) for bearing in teeth.bearings])
            for _ in range(2)
        )
        turn = teeth.turn(first, behind=second)
        cycle_summary = summary.summarise_turn(teeth, turn)
        assert near_range.motor_work_J < cycle_summary.motor_work_J < far.motor_work_J
        for stage in range(2):
            assert (
                near_range.efficiency[stage]
                > cycle_summary.efficiency[stage]
                > far.efficiency[stage]
            )
        for force, bound in bounds.items():
            assert cycle_summary.largest_N[force] <= bound * (1 + 1e-12)
    assert near_range.lost_J["cams"] == pytest.approx(far.lost_J["cams"], rel=1e-12)
    assert bounds["F_A1"] < 1.1 * near_range.largest_N["F_A1"]


def test_losses_grow_with_friction_beyond_first_order() -> None:
    """To first order a loss is that of the frictionless normal force: halving the friction halves
    what is left.
    """
    teeth = cut_gears("wang2017")
    per_friction = []
    for angle in (1e-3, 5e-4, 2.5e-4):
        cycle_summary = summary.summarise_turn(
            teeth, teeth.evaluate_sliding(teeth.equal, friction=angle)
        )
        per_friction.append(cycle_summary.lost_J["stage 1"] / np.tan(angle))
    assert per_friction[0] - per_friction[1] == pytest.approx(
        2 * (per_friction[1] - per_friction[2]), rel=2e-2
    )
    assert abs(per_friction[0] / per_friction[2] - 1) < 1e-3


def test_integrals_split_at_jumps() -> None:
    jumps = np.array([0.3, 0.3 + 1e-9, 1.7, 4.0])
    angles = Angles.from_jumps(jumps)

    def saw(phi: Array) -> Array:
        return np.mod(phi - 0.3, np.pi) * (np.mod(phi - 0.3, np.pi) < 1.4)

    assert angles.weights.sum() == pytest.approx(1, abs=1e-14)
    assert np.ptp(angles.phi) < TURN
    assert angles.mean(saw(angles.phi)) == pytest.approx(1.4**2 / 2 / np.pi, abs=1e-14)
    assert saw(angles.phi).max() == pytest.approx(1.4, abs=2e-8)
    late = Angles.from_jumps(jumps[:2])
    assert late.mean(saw(late.phi)) != pytest.approx(1.4**2 / 2 / np.pi, abs=1e-5)


def test_result_reports_all_losses() -> None:
    teeth = cut_gears("wang2017")
    rubbing = summary.compute_friction(teeth.device, teeth.x, teeth.stages)
    result = rubbing.result
    assert result.pairs == [2, 2]
    assert result.support_changed_N < 1e-11
    for turn in (result.without, result.convention, result.sliding):
        assert turn.largest_N.keys() == turn.rms_N.keys() == result.at_most_N.keys()
        assert turn.largest_N.keys() >= JOINTS.keys() >= TOTALS
    assert result.without.efficiency == result.convention.efficiency == [1, 1]
    assert 0.97 < result.sliding.efficiency[0] < 0.995
    columns = rubbing.columns()
    assert columns["F_A1_sliding_N"].max() == pytest.approx(
        result.sliding.largest_N["F_A1"], rel=1e-14
    )
    assert np.all(np.diff(columns["phi_deg"]) >= 0)
