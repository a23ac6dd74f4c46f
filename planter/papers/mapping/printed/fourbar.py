"""The four-bar linkage of the two smallest dyads in the poses of its synthesis."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from planter.audit.registry import MM, Inputs, Value, formula
from planter.kernels import Array
from planter.papers.mapping.linkage import FourBar, reversals, standings
from planter.papers.mapping.printed.dyads import choose_dyad, poses, solve_poses


@formula("poses in the assembly of one of them")
def in_assembly(inputs: Inputs) -> Value:
    """Return the number of poses that the linkage passes in the assembly of the first of them."""
    linkage = _linkage(inputs)
    if linkage is None:
        return None
    names: Sequence[str] = inputs[inputs["poses"]]
    by_name = dict(zip(names, standings(linkage, poses(inputs)), strict=True))
    counted = [name for name in names if name in inputs["counted"]]
    return float(sum(by_name[name].assembly == by_name[counted[0]].assembly for name in counted))


@formula("driver is a crank")
def is_crank(inputs: Inputs) -> Value:
    """1 if the shorter dyad turns fully, else 0."""
    linkage = _linkage(inputs)
    return None if linkage is None else float(linkage.turns_round)


@formula("largest reversal between neighbouring poses")
def largest_reversal(inputs: Inputs) -> Value:
    """Largest rotation by which the arm must turn back relative to the carrier between two poses
    [deg]; 0 if none.

    A carrier that turns once passes the poses in the order of their crank angles.
    """
    linkage = _linkage(inputs)
    if linkage is None:
        return None
    where = poses(inputs)
    crank = np.radians([standing.crank_angle_deg for standing in standings(linkage, where)])
    return max((r.deg for r in reversals(crank, where[:, 2])), default=0.0)


@formula("distance of a hinge outside the poses")
def outside_distance(inputs: Inputs) -> Value:
    """Distance of a dyad's fixed hinge from the polygon through the poses' points [mm]; negative
    inside.
    """
    dyad = choose_dyad(inputs)
    return None if dyad is None else _distance(poses(inputs)[:, :2], dyad.centre) / MM


def _distance(corners: Array, point: Array) -> float:
    """Signed distance of a point (2,) from a closed polygon (n, 2): even-odd rule."""
    start, end = corners, np.roll(corners, -1, axis=0)
    frame = end - start
    share = np.clip(((point - start) * frame).sum(1) / (frame**2).sum(1), 0, 1)
    away = float(np.linalg.norm(start + share[:, None] * frame - point, axis=1).min())
    crossed = (start[:, 1] > point[1]) != (end[:, 1] > point[1])
    with np.errstate(divide="ignore", invalid="ignore"):
        x = start[:, 0] + (point[1] - start[:, 1]) * frame[:, 0] / frame[:, 1]
    return -away if (crossed & (point[0] < x)).sum() % 2 else away


def _linkage(inputs: Inputs) -> FourBar | None:
    dyads = solve_poses(inputs).dyads
    return FourBar(dyads[0], dyads[1]) if len(dyads) > 1 else None
