"""Two dyads as a four-bar linkage with the arm as its coupler: type, range of the crank, circuits,
coupler path.

A position is a crank angle and an assembly: +1 where the follower's moving hinge lies to the left
of the line from the crank's moving hinge to the follower's fixed one, -1 to the right of it.
Positions that the linkage can reach from each other without being taken apart form a circuit; on a
circuit that the crank cannot turn round on, the two assemblies are its branches, which meet where
the crank stands still (Chase and Mirth, Circuits and branches of single-degree-of- freedom planar
linkages, 1993).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from planter.kernels import Array
from planter.numerics.arrays import TURN, wrap_angle
from planter.papers.mapping import model
from planter.papers.mapping.dyads import Dyad, to_pair
from planter.papers.mapping.results import AtPose, Back, DefectsFound

Type = Literal["crank-rocker", "double-crank", "double-rocker", "non-grashof"]
_ROUNDING = 1e-12


@dataclass(frozen=True)
class Reach:
    """Crank angles from `start` over `span` [rad] on one circuit; `whole` where the crank turns
    round.
    """

    start: float
    span: float
    is_full_turn: bool


@dataclass(frozen=True)
class Path:
    """The coupler along a circuit: crank and arm angle (n,) [rad], tip (2, n) [m], transmission
    angle (n,) [rad].
    """

    circuit: int
    assembly: Array
    theta: Array
    phi: Array
    tip: Array
    transmission: Array


@dataclass(frozen=True)
class FourBar:
    """The linkage of two dyads; the first, which is the shorter, drives."""

    crank: Dyad
    follower: Dyad

    @cached_property
    def lengths(self) -> tuple[float, float, float, float]:
        """Frame, crank, coupler, follower [m]."""
        frame = float(np.hypot(*(self.follower.centre - self.crank.centre)))
        coupler = float(np.hypot(*(self.follower.point - self.crank.point)))
        return frame, self.crank.radius, coupler, self.follower.radius

    @cached_property
    def direction(self) -> float:
        """Direction of the frame, from the crank's fixed hinge to the follower's [rad]."""
        dx, dy = self.follower.centre - self.crank.centre
        return float(np.arctan2(dy, dx))

    @property
    def grashof(self) -> bool:
        """Whether the shortest and the longest link together are no longer than the other two."""
        ordered = sorted(self.lengths)
        return ordered[0] + ordered[3] <= (ordered[1] + ordered[2]) * (1 + _ROUNDING)

    @property
    def type(self) -> Type:
        """Type by Grashof's rule, named after the shortest link, the one that can turn round to its
        neighbours.
        """
        if not self.grashof:
            return "non-grashof"
        shortest = int(np.argmin(self.lengths))
        return ("double-crank", "crank-rocker", "double-rocker", "crank-rocker")[shortest]

    @cached_property
    def reaches(self) -> tuple[Reach, ...]:
        """Ranges of the crank on the circuits, one each; a whole turn has a circuit for each
        assembly.
        """
        frame, crank, coupler, follower = self.lengths
        twice = 2 * frame * crank
        smallest, largest = (
            frame**2 + crank**2 - (coupler + follower) ** 2,
            frame**2 + crank**2 - (coupler - follower) ** 2,
        )
        rounding = _ROUNDING * sum(self.lengths) ** 2
        inward, outward = largest >= twice - rounding, smallest <= -twice + rounding
        if inward and outward:
            return (Reach(self.direction, TURN, True),) * 2
        low = 0.0 if inward else float(np.arccos(np.clip(largest / twice, -1, 1)))
        high = np.pi if outward else float(np.arccos(np.clip(smallest / twice, -1, 1)))
        if inward:
            return (Reach(self.direction - high, 2 * high, False),)
        if outward:
            return (Reach(self.direction + low, TURN - 2 * low, False),)
        return Reach(self.direction + low, high - low, False), Reach(
            self.direction - high, high - low, False
        )

    @property
    def turns_round(self) -> bool:
        """Whether the crank makes whole turns."""
        return self.reaches[0].is_full_turn

    def circuit(self, theta: float, assembly: int) -> int:
        """Number of the circuit, 1 or 2, of a position."""
        if self.turns_round:
            return 1 if assembly > 0 else 2
        return 1 if len(self.reaches) == 1 or np.sin(theta - self.direction) > 0 else 2

    def assembly(self, crank_hinge: Array, follower_hinge: Array) -> Array:
        """Sides +1 or -1 (n,) for the places (n, 2) of the two moving hinges."""
        line, link = self.follower.centre - crank_hinge, follower_hinge - crank_hinge
        return np.where(line[:, 0] * link[:, 1] - line[:, 1] * link[:, 0] >= 0, 1, -1)

    def arm_angle(self, theta: Array, assembly: Array) -> Array:
        """Angle of the arm (n,) [rad] at crank angles within reach; beyond it, as at the nearest
        reachable one.
        """
        vectors = self.crank.vector, self.follower.vector
        of_cos, of_sin, alone = model.loop(theta, *vectors)
        size = np.hypot(of_cos, of_sin)
        middle = np.arctan2(-of_sin, -of_cos)
        phi = middle + assembly * np.arccos(np.clip(alone / np.where(size > 0, size, 1), -1, 1))
        gap, _, slope = model.evaluate_closure(theta, phi, *vectors)
        steep = np.abs(slope) > 1e-3 * size
        return phi - np.where(steep, gap / np.where(steep, slope, 1), 0)

    def tip(self, theta: Array, phi: Array) -> Array:
        """Place of the tip (2, n) [m]."""
        return model.arm(theta, phi, self.crank.vector)[:2]

    def transmission(self, theta: Array, phi: Array) -> Array:
        """Transmission angle (n,) [rad]: between coupler and follower, folded into [0, pi/2]."""
        angle = model.transmission(theta, phi, self.crank.vector, self.follower.vector)
        return np.minimum(angle, np.pi - angle)

    @property
    def least_transmission(self) -> float:
        """Least transmission angle over the crank's range [rad]: zero where the crank does not turn
        round.
        """
        if not self.turns_round:
            return 0.0
        theta = self.direction + np.array([0, np.pi])
        return float(self.transmission(theta, self.arm_angle(theta, np.ones(2))).min())

    def path(self, circuit: int, samples: int = 360) -> Path:
        """The coupler along circuit 1 or 2 at even steps: once round the crank, or over both
        branches and back.
        """
        return self.path_at(circuit, np.arange(samples) / samples)

    def path_at(self, circuit: int, shares: Array) -> Path:
        """The coupler at shares (n,) of the way along a circuit, which rise within [0, 1]."""
        reach = self.reaches[circuit - 1]
        place = TURN * shares
        if reach.is_full_turn:
            theta = reach.start + place
            assembly = np.full(len(shares), 1 if circuit == 1 else -1)
        else:
            theta = reach.start + reach.span * (1 - np.cos(place)) / 2
            assembly = np.where(place < np.pi, 1, -1)
        phi = np.unwrap(self.arm_angle(theta, assembly))
        return Path(
            circuit, assembly, theta, phi, self.tip(theta, phi), self.transmission(theta, phi)
        )

    def place_on_circuit(self, theta: float, assembly: int) -> float:
        """Place of a position along its circuit [rad], growing once by 2 pi round it."""
        circuit = self.circuit(theta, assembly)
        reach = self.reaches[circuit - 1]
        if reach.is_full_turn:
            return float(np.mod(theta, TURN))
        share = np.mod(theta - reach.start + TURN * 1e-9, TURN) / reach.span
        angle = float(np.arccos(np.clip(1 - 2 * share, -1, 1)))
        return angle if assembly > 0 else TURN - angle


Whole = NDArray[np.int64]


def standings(linkage: FourBar, poses: Array) -> list[AtPose]:
    """Return crank angle, assembly and circuit of each pose (n, 3) with the errors of the linkage
    at that crank angle.
    """
    first, second = (
        model.place_point(poses, dyad.point) for dyad in (linkage.crank, linkage.follower)
    )
    theta, assembly = linkage.crank.carrier_angles(poses), linkage.assembly(first, second)
    phi = linkage.arm_angle(theta, assembly)
    missed = np.hypot(*(linkage.tip(theta, phi) - poses[:, :2].T))
    turned = wrap_angle(phi - poses[:, 2])
    transmission = linkage.transmission(theta, phi)
    return [
        AtPose(
            pose=k + 1,
            crank_angle_deg=math.degrees(theta[k]),
            assembly=int(assembly[k]),
            circuit=linkage.circuit(float(theta[k]), int(assembly[k])),
            hinges_mm=(to_pair(first[k] * 1e3), to_pair(second[k] * 1e3)),
            position_error_mm=float(missed[k]) * 1e3,
            angle_error_deg=math.degrees(turned[k]),
            transmission_deg=math.degrees(transmission[k]),
        )
        for k in range(len(poses))
    ]


def find_defects(linkage: FourBar, positions: Sequence[AtPose]) -> tuple[DefectsFound, int]:
    """Return the defects of a linkage for its poses, and the sense of the crank, 0 without an order.

    Circuit defect: poses on different circuits.

    Branch defect: on one circuit, but on branches of it that the driving crank does not lead into
    each other. Order defect: not met in their order, in either sense.

    A crank that turns round meets the poses by its angle, whatever their circuit; else each circuit
    is looked at.
    """
    circuits = {s.circuit for s in positions}
    branch = any(len({s.assembly for s in positions if s.circuit == c}) > 1 for c in circuits)
    if linkage.turns_round:
        sense = in_order([math.radians(s.crank_angle_deg) for s in positions])
    else:
        places = {
            c: [
                linkage.place_on_circuit(math.radians(s.crank_angle_deg), s.assembly)
                for s in positions
                if s.circuit == c
            ]
            for c in circuits
        }
        senses = [in_order(circuit_positions) for circuit_positions in places.values()]
        sense = 0 if 0 in senses else senses[0]
    return DefectsFound(sense == 0, branch, len(circuits) > 1), sense


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
class Turn:
    """Poses as one closed turn of the carrier meets them: `order` (n,) of the poses; from each to
    the next, how far the carrier moves `ahead` (n,) and how far the arm's relative rotation `falls`
    (n,) [rad], together one turn each.
    """

    order: Whole
    ahead: Array
    falls: Array


def one_turn(theta: Array, phi: Array) -> Turn:
    """The turn that passes poses with carrier angles (n,) and arm angles (n,) with the least
    turning back.

    The arm comes back to its place without a net rotation, so phi - theta falls by one turn. From
    each pose to the next it falls by what the two say, up to whole turns; taken between nothing and
    one turn, these falls add up to whole turns. For each turn above the first, one step must rise
    instead: those that rise least.
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


def reversals(theta: Array, phi: Array) -> list[Back]:
    """Return the pairs of poses between which the arm's rotation phi - theta must reverse on one
    closed turn of the carrier, in the order of its angles (n,); empty if it can change in one sense
    only.

    Where two poses ask for different arm angles at one carrier angle, their difference counts.
    """
    turn = one_turn(theta, phi)
    after = np.roll(turn.order, -1)
    turned_back = np.where((turn.ahead < _SAME) & (turn.falls > _SAME), turn.falls, -turn.falls)
    return [
        Back(int(turn.order[k]) + 1, int(after[k]) + 1, math.degrees(turned_back[k]))
        for k in np.flatnonzero(turned_back > 0)
    ]


def _step(angle: Array) -> Array:
    """Angles in [0, 2 pi); what is a whole turn but for rounding is nothing."""
    steps = np.mod(angle, TURN)
    return np.where(steps > TURN - _SAME, 0.0, steps)


_SAME = 1e-9
