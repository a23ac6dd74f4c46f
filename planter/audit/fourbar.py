"""The four-bar linkage of two dyads in the poses that it was made for: assembly, crank angle, sense of rotation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from planter.audit.dyads import Dyad, conditions, dyads, image, placed
from planter.audit.registry import Inputs, Value, formula
from planter.kernels import Array


@dataclass(frozen=True)
class Linkage:
    """A driving dyad, the other one, and the poses (n, 3) of the coupler [mm, mm, deg]."""

    driver: Dyad
    other: Dyad
    poses: Array

    @property
    def assemblies(self) -> Array:
        """Side (n,) of the line moving hinge 1 - fixed hinge 2 on which moving hinge 2 lies: +1 or -1."""
        first, second = self._hinges(self.driver), self._hinges(self.other)
        along, across = self.other.centre - first, second - first
        return np.sign(along[:, 0] * across[:, 1] - along[:, 1] * across[:, 0])

    @property
    def crank_angles(self) -> Array:
        """Direction (n,) from the driver's fixed to its moving hinge [deg], in [0, 360)."""
        x, y = (self._hinges(self.driver) - self.driver.centre).T
        return np.degrees(np.arctan2(y, x)) % 360

    @property
    def turns_fully(self) -> bool:
        """Whether the driver is a crank: it is the shortest link, and with the longest shorter than the other two."""
        frame = float(np.linalg.norm(self.driver.centre - self.other.centre))
        coupler = float(np.linalg.norm(self.driver.point - self.other.point))
        lengths = sorted([frame, coupler, self.driver.radius, self.other.radius])
        return self.driver.radius == lengths[0] and lengths[0] + lengths[3] < lengths[1] + lengths[2]

    def _hinges(self, dyad: Dyad) -> Array:
        return np.array([placed(dyad.point, pose) for pose in self.poses])


def reversals(linkage: Linkage) -> list[tuple[int, int, float]]:
    """Neighbours in the order of the crank angles, and by how much the coupler outruns the crank between them [deg].

    The coupler swings and the crank turns; the coupler's rotation relative to the crank keeps its sense from one pose
    to the next if it falls. Poses count from 1.
    """
    order = np.argsort(linkage.crank_angles)
    found = []
    for i, j in zip(order, np.roll(order, -1), strict=True):
        turned = (linkage.crank_angles[j] - linkage.crank_angles[i]) % 360
        found.append((int(i) + 1, int(j) + 1, float(linkage.poses[j, 2] - linkage.poses[i, 2] - turned)))
    return found


@formula("poses in the assembly of one of them")
def in_assembly(inputs: Inputs) -> Value:
    """How many of some poses the linkage of the two smallest dyads passes in the assembly of the first of them."""
    linkage = _linkage(inputs)
    if linkage is None:
        return None
    names: Sequence[str] = inputs[inputs["poses"]]
    signs = dict(zip(names, linkage.assemblies, strict=True))
    wanted = [name for name in names if name in inputs["counted"]]
    return float(sum(signs[name] == signs[wanted[0]] for name in wanted))


@formula("driver is a crank")
def is_crank(inputs: Inputs) -> Value:
    """1 if the shorter dyad turns fully, else 0."""
    linkage = _linkage(inputs)
    return None if linkage is None else float(linkage.turns_fully)


@formula("largest reversal between neighbouring poses")
def largest_reversal(inputs: Inputs) -> Value:
    """Largest rotation by which the arm must turn back relative to the carrier between two poses [deg]; below 0: none.

    A carrier that turns once passes the poses in the order of their crank angles.
    """
    linkage = _linkage(inputs)
    return None if linkage is None else max(deg for _, _, deg in reversals(linkage))


@formula("eigenvalues that vanish")
def vanishing_eigenvalues(inputs: Inputs) -> float:
    """How many eigenvalues of A^T A are zero: columns of A less its rank."""
    rows = conditions(np.array([image(pose) for pose in _poses(inputs)]))
    scaled = rows / np.linalg.norm(rows, axis=0)
    return float(rows.shape[1] - np.linalg.matrix_rank(scaled))


@formula("distance of a hinge outside the poses")
def outside(inputs: Inputs) -> Value:
    """Distance of a dyad's fixed hinge from the polygon through the poses' points [mm]; negative inside."""
    poses, found = _poses(inputs), dyads(_poses(inputs))
    number = inputs["dyad"]
    return _distance(poses[:, :2], found[number - 1].centre) if number <= len(found) else None


def _distance(corners: Array, point: Array) -> float:
    """Signed distance of a point (2,) from a closed polygon (n, 2): even-odd rule."""
    start, end = corners, np.roll(corners, -1, axis=0)
    along = end - start
    share = np.clip(((point - start) * along).sum(1) / (along**2).sum(1), 0, 1)
    away = float(np.linalg.norm(start + share[:, None] * along - point, axis=1).min())
    crossed = (start[:, 1] > point[1]) != (end[:, 1] > point[1])
    with np.errstate(divide="ignore", invalid="ignore"):
        x = start[:, 0] + (point[1] - start[:, 1]) * along[:, 0] / along[:, 1]
    return -away if (crossed & (point[0] < x)).sum() % 2 else away


def _poses(inputs: Inputs) -> Array:
    return np.array([inputs[name] for name in inputs[inputs["poses"]]], dtype=float)


def _linkage(inputs: Inputs) -> Linkage | None:
    poses = _poses(inputs)
    found = dyads(poses)
    return Linkage(found[0], found[1], poses) if len(found) > 1 else None
