"""Four-bar linkages: closed loops, Grashof's rule, circuits and branches, order of poses,
reversals.
"""

import numpy as np
import pytest

from planter.numerics.arrays import TURN
from planter.papers.mapping.dyads import solve_dyads
from planter.papers.mapping.linkage import (
    FourBar,
    find_defects,
    one_turn,
    reversals,
    standings,
)
from planter.papers.mapping.results import DefectsFound
from tests.planter.papers.mapping.data import CORRECTED, bar, si

# frame, crank, coupler, follower; the types are those of any textbook (Norton, Design of machinery,
# section 2.13)
LINKAGES = {
    "crank-rocker": (0.20, 0.08, 0.19, 0.17),
    "double-crank": (0.08, 0.17, 0.19, 0.20),
    "double-rocker": (0.20, 0.17, 0.08, 0.19),
    "non-grashof": (0.20, 0.12, 0.10, 0.13),
}
PATENT = FourBar(*solve_dyads(si(CORRECTED)).dyads)


def hinges(linkage: FourBar, theta: np.ndarray, phi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Moving hinges by complex numbers, from the tip."""
    tip = linkage.tip(theta, phi)
    z, turn = tip[0] + 1j * tip[1], np.exp(1j * phi)
    return z + turn * complex(*linkage.crank.point), z + turn * complex(*linkage.follower.point)


@pytest.mark.parametrize("kind", LINKAGES)
def test_links_keep_their_lengths_along_every_circuit(kind: str) -> None:
    linkage = bar(*LINKAGES[kind])
    assert linkage.lengths == pytest.approx(LINKAGES[kind])
    for circuit in range(1, len(linkage.reaches) + 1):
        path = linkage.path(circuit)
        first, second = hinges(linkage, path.theta, path.phi)
        arm = first - complex(*linkage.crank.centre)
        assert np.exp(1j * np.angle(arm)) == pytest.approx(np.exp(1j * path.theta), abs=1e-12)
        assert np.abs(arm) == pytest.approx(linkage.crank.radius, rel=1e-12)
        assert np.abs(second - first) == pytest.approx(linkage.lengths[2], rel=1e-12)
        assert np.abs(second - complex(*linkage.follower.centre)) == pytest.approx(
            linkage.follower.radius, abs=1e-10
        )
        assembly = linkage.assembly(
            np.column_stack([first.real, first.imag]), np.column_stack([second.real, second.imag])
        )
        inside = path.transmission > 1e-3
        assert (assembly == path.assembly)[inside].all()


@pytest.mark.parametrize("kind", LINKAGES)
def test_types_after_grashof(kind: str) -> None:
    linkage = bar(*LINKAGES[kind])
    assert linkage.type == kind
    assert linkage.grashof == (kind != "non-grashof")
    assert linkage.turns_round == (kind in ("crank-rocker", "double-crank"))
    assert len(linkage.reaches) == (1 if kind == "non-grashof" else 2)


@pytest.mark.parametrize("seed", range(30))
def test_reach_limit_closes_the_triangle(seed: int) -> None:
    frame, crank, coupler, follower = np.random.default_rng(seed).uniform(0.05, 0.2, 4)
    crank, follower = min(crank, follower), max(crank, follower)
    lengths = frame, crank, coupler, follower
    if max(lengths) > sum(lengths) / 2:
        return
    linkage = bar(*lengths)
    theta = np.linspace(0, TURN, 7201)
    gap = np.abs(crank * np.exp(1j * theta) - frame * np.exp(1j * linkage.direction))
    closes = (gap <= coupler + follower) & (gap >= abs(coupler - follower))
    spans = [r.span for r in (linkage.reaches[:1] if linkage.turns_round else linkage.reaches)]
    assert sum(spans) == pytest.approx(closes.mean() * TURN, abs=0.01)
    assert linkage.turns_round == bool(closes.all())
    assert linkage.grashof == (linkage.turns_round or len(linkage.reaches) == 2)


@pytest.mark.parametrize("kind", LINKAGES)
def test_circuits_are_closed_and_apart(kind: str) -> None:
    """The arm comes back to its place along a circuit without a jump."""
    linkage = bar(*LINKAGES[kind])
    for circuit in range(1, len(linkage.reaches) + 1):
        path = linkage.path(circuit, 2880)
        places = np.column_stack([path.tip, path.tip[:, 0]])
        assert np.hypot(*np.diff(places)).max() < 0.01
        seen = {
            linkage.circuit(float(t), int(a))
            for t, a in zip(path.theta[1:-1], path.assembly[1:-1], strict=True)
        }
        assert seen == {circuit}


def test_poses_of_the_patent_stand_on_two_circuits() -> None:
    """Three on the first, two on the second, as the patent says of its two linkages; lengths by its
    printed hinges.
    """
    poses = si(CORRECTED)
    located = standings(PATENT, poses)
    assert [s.circuit for s in located] == [1, 1, 1, 2, 2]
    assert max(s.position_error_mm for s in located) < 1e-11
    assert np.hypot(137.487 + 43.835, -70.4616 - 15.533) == pytest.approx(
        PATENT.lengths[0] * 1e3, abs=1e-3
    )
    assert np.hypot(223.421 - 26.1041, 112.399 - 86.6203) == pytest.approx(
        PATENT.lengths[2] * 1e3, abs=1e-3
    )
    assert (PATENT.type, PATENT.grashof) == ("crank-rocker", True)
    assert find_defects(PATENT, located) == (DefectsFound(False, False, True), -1)
    assert np.hypot(*PATENT.crank.point) * 1e3 == pytest.approx(211.5459, abs=5e-5)


def trace(linkage: FourBar, circuit: int, steps: list[int]) -> np.ndarray:
    path = linkage.path(circuit)
    return np.column_stack([path.tip.T, path.phi])[steps]


def test_ordered_poses_have_no_defects() -> None:
    linkage = bar(*LINKAGES["crank-rocker"])
    poses = trace(linkage, 1, [10, 90, 170, 250, 330])
    none = DefectsFound(False, False, False)
    assert find_defects(linkage, standings(linkage, poses)) == (none, 1)
    assert find_defects(linkage, standings(linkage, poses[::-1])) == (none, -1)
    assert find_defects(linkage, standings(linkage, poses[[0, 2, 1, 3, 4]]))[0].order


def test_branch_defect_of_rocking_crank() -> None:
    linkage = bar(*LINKAGES["non-grashof"])
    three = standings(linkage, trace(linkage, 1, [20, 60, 100, 140]))
    assert not find_defects(linkage, three)[0].branch
    both = standings(linkage, trace(linkage, 1, [20, 100, 200, 300]))
    assert find_defects(linkage, both)[0] == DefectsFound(False, True, False)


def test_circuits_of_a_double_rocker_are_the_sides_of_the_frame() -> None:
    linkage = bar(*LINKAGES["double-rocker"])
    poses = np.vstack([trace(linkage, 1, [20, 100]), trace(linkage, 2, [50, 120, 300])])
    located = standings(linkage, poses)
    assert [s.circuit for s in located] == [1, 1, 2, 2, 2]
    assert find_defects(linkage, located)[0].circuit
    assert find_defects(linkage, located[2:])[0].branch


def test_resting_arm_is_passable_in_a_single_sense() -> None:
    theta = np.radians([10, 80, 200, 300])
    assert reversals(theta, np.zeros(4)) == []
    turn = one_turn(theta, np.zeros(4))
    assert np.degrees(turn.falls) == pytest.approx([70, 120, 100, 70])


def test_arm_faster_than_carrier_reverses() -> None:
    """From 80 to 110 deg the carrier turns by 30, the arm by 50: by 20 deg it turns back."""
    theta, phi = np.radians([10, 80, 110, 300]), np.radians([0, 0, 50, 0])
    (reversal,) = reversals(theta, phi)
    assert (reversal.from_pose, reversal.to_pose) == (2, 3)
    assert reversal.deg == pytest.approx(20)
    assert reversals(theta, np.radians([0, 0, 29, 0])) == []


def test_two_arm_angles_at_a_carrier_angle_conflict() -> None:
    (reversal,) = reversals(np.radians([10, 80, 80, 300]), np.radians([0, 0, -20, 0]))
    assert reversal.deg == pytest.approx(20)


def test_poses_of_the_patent_make_the_arm_turn_back() -> None:
    """By hand: arm less carrier is 14.15 deg in pose 3 and -17.10 deg in pose 4, which comes 65.7
    deg before it.
    """
    poses = si(CORRECTED)
    theta = np.radians([s.crank_angle_deg for s in standings(PATENT, poses)])
    (reversal,) = reversals(theta, poses[:, 2])
    assert (reversal.from_pose, reversal.to_pose) == (4, 3)
    assert reversal.deg == pytest.approx(97 - np.degrees(theta[2] - theta[3]), abs=1e-9)
