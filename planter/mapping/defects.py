"""Poses on a four-bar linkage: crank angles and circuits, whether it can visit them, and in which order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from planter.kernels import Array
from planter.mapping import model
from planter.mapping.linkage import FourBar
from planter.numerics.arrays import TURN, wrap_angle

Whole = NDArray[np.int64]


@dataclass(frozen=True)
class Standing:
    """A pose on a linkage: crank angle [rad], assembly, circuit, both moving hinges (2, 2) [m].

    `position_error` [m] and `angle_error` [rad] are those of the linkage at that crank angle; `transmission` is the
    transmission angle there [rad].
    """

    crank_angle: float
    assembly: int
    circuit: int
    hinges: Array
    position_error: float
    angle_error: float
    transmission: float


def standings(linkage: FourBar, poses: Array) -> list[Standing]:
    """Return crank angle, assembly and circuit of each pose (n, 3)."""
    first, second = (model.place_point(poses, dyad.point) for dyad in (linkage.crank, linkage.follower))
    dx, dy = (first - linkage.crank.centre).T
    theta, assembly = np.arctan2(dy, dx), linkage.assembly(first, second)
    phi = linkage.arm_angle(theta, assembly)
    missed = np.hypot(*(linkage.tip(theta, phi) - poses[:, :2].T))
    turned = wrap_angle(phi - poses[:, 2])
    transmission = linkage.transmission(theta, phi)
    return [
        Standing(float(theta[k]), int(assembly[k]), linkage.circuit(float(theta[k]), int(assembly[k])),
                 np.array([first[k], second[k]]), float(missed[k]), float(turned[k]), float(transmission[k]))
        for k in range(len(poses))
    ]  # fmt: skip


@dataclass(frozen=True)
class Defects:
    """Defects of a linkage for its poses; `sense` is that of the crank if the order is right, else 0."""

    order: bool
    branch: bool
    circuit: bool
    sense: int


def defects(linkage: FourBar, positions: Sequence[Standing]) -> Defects:
    """Circuit defect: poses on different circuits. Branch defect: on one circuit, but on branches of it that the
    driving crank does not lead into each other. Order defect: not met in their order, in either sense.

    A crank that turns round meets the poses by its angle, whatever their circuit; else each circuit is looked at.
    """
    circuits = {s.circuit for s in positions}
    branch = any(len({s.assembly for s in positions if s.circuit == c}) > 1 for c in circuits)
    if linkage.turns_round:
        sense = in_order([s.crank_angle for s in positions])
    else:
        places = {c: [linkage.place_on_circuit(s.crank_angle, s.assembly) for s in positions if s.circuit == c]
                  for c in circuits}  # fmt: skip
        senses = [in_order(circuit_positions) for circuit_positions in places.values()]
        sense = 0 if 0 in senses else senses[0]
    return Defects(sense == 0, branch, len(circuits) > 1, sense)


def in_order(angles: Sequence[float]) -> int:
    """Sense in which angles [rad] follow each other round one turn: +1, -1, or 0 if they do not.

    >>> in_order([0.1, 2.0, 5.0]), in_order([5.0, 2.0, 0.1]), in_order([0.1, 3.0, 2.0, 5.0])
    (1, -1, 0)
    """
    steps = np.mod(np.roll(angles, -1) - np.asarray(angles), TURN)
    if np.isclose(steps.sum(), TURN):
        return 1
    return -1 if np.isclose((TURN - steps).sum(), TURN) else 0


@dataclass(frozen=True)
class Reversal:
    """Between two poses, by their places in the list, the arm must turn back against the carrier by `angle` [rad]."""

    start: int
    end: int
    angle: float


@dataclass(frozen=True)
class Turn:
    """Poses as one closed turn of the carrier meets them: `order` (n,) of the poses; from each to the next, how far
    the carrier moves `ahead` (n,) and how far the arm's relative rotation `falls` (n,) [rad], together one turn each.
    """

    order: Whole
    ahead: Array
    falls: Array


def one_turn(theta: Array, phi: Array) -> Turn:
    """The turn that passes poses with carrier angles (n,) and arm angles (n,) with the least turning back.

    The arm comes back to its place without a net rotation, so phi - theta falls by one turn. From each pose to the
    next it falls by what the two say, up to whole turns; taken between nothing and one turn, these falls add up to
    whole turns. For each turn above the first, one step must rise instead: those that rise least.
    """
    order = np.argsort(np.mod(theta, TURN), kind="stable").astype(np.int64)
    after = np.roll(order, -1)
    ahead = _step(theta[after] - theta[order])
    falls = _step((phi - theta)[order] - (phi - theta)[after])
    if ahead.sum() < 1:
        ahead[-1] += TURN  # all poses at one carrier angle: the turn comes after them
    if falls.sum() < 1:
        falls[int(np.argmax(ahead))] += (
            TURN  # a body that stands still on the carrier: the turn comes at the widest gap
        )
    surplus = round(float(falls.sum()) / TURN) - 1
    falls[np.argsort(-falls, kind="stable")[:surplus]] -= TURN
    return Turn(order, ahead, falls)


def reversals(theta: Array, phi: Array) -> list[Reversal]:
    """Return the pairs of poses between which the arm's rotation phi - theta must reverse on one closed turn of the
    carrier, in the order of its angles (n,); empty if it can change in one sense only.

    Where two poses ask for different arm angles at one carrier angle, their difference counts.
    """
    turn = one_turn(theta, phi)
    after = np.roll(turn.order, -1)
    turned_back = np.where((turn.ahead < _SAME) & (turn.falls > _SAME), turn.falls, -turn.falls)
    return [Reversal(int(turn.order[k]), int(after[k]), float(turned_back[k])) for k in np.flatnonzero(turned_back > 0)]


def _step(angle: Array) -> Array:
    """Angles in [0, 2 pi); what is a whole turn but for rounding is nothing."""
    steps = np.mod(angle, TURN)
    return np.where(steps > TURN - _SAME, 0.0, steps)


_SAME = 1e-9
