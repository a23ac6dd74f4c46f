"""Drawings of poses with their linkage, and of the gear train on its carrier, with their symbols."""

from __future__ import annotations

import numpy as np

from planter.kernels import Array
from planter.mapping import model
from planter.mapping.report.figures import MM
from planter.mapping.report.train_figures import centres, outlines
from planter.mapping.synthesis import Linkage, Synthesis
from planter.mapping.training import Training
from planter.view.scene import Body, Outline
from planter.view.sheet import Angle, Length, Mark, Sheet, Spot, still
from planter.view.sheet import heading as direction

POSE = -2
"""The pose that the linkage is drawn in: the last but one, where its bars lie well apart."""
_HINGES = (0, 1, 1, 2)
"""At which hinge of the carrier each of the four gears turns."""


def sheets(synthesis: Synthesis, train: Training | None) -> list[Sheet]:
    """All drawings of what was found: those of which there is one."""
    linkages = [_linkage(linkage, synthesis.poses[POSE], synthesis.poses) for linkage in synthesis.linkages[:1]]
    return [*linkages, *([] if train is None else [_train(train)])]


def _linkage(linkage: Linkage, pose: Array, poses: Array) -> Sheet:
    """The first linkage in a pose; the origin of the moving frame is the tip."""
    tip, heading = MM * pose[:2], float(np.degrees(pose[2]))
    crank, follower = (
        MM * model.place_point(pose[None, :], dyad.point)[0] for dyad in (linkage.bar.crank, linkage.bar.follower)
    )
    fixed = [MM * dyad.centre for dyad in (linkage.bar.crank, linkage.bar.follower)]
    bodies = (
        Body("frame", (Outline(np.array(fixed), "ground", closed=False),)),
        Body("crank", (Outline(np.array([fixed[0], crank]), "frame", closed=False),)),
        Body("follower", (Outline(np.array([fixed[1], follower]), "frame", closed=False),)),
        Body("arm", (Outline(np.array([crank, follower, tip]), "body", shade=0),)),
    )
    size = float(np.ptp(MM * poses[:, :2], axis=0).max())
    marks: list[Mark] = [
        Spot(("d1", "d2"), tip),
        Spot(("tip_x_mm", "tip_y_mm"), tip),
        Angle(("phi", "phi_deg"), tip, 0, heading, 0.2 * size),
        Spot(("x", "y"), crank),
        Spot(("X", "Y"), crank),
        Spot(("X_c", "Y_c"), fixed[0]),
        Spot(("x_f", "y_f"), follower),
        Spot(("X_f", "Y_f"), fixed[1]),
        Length(("L1",), fixed[0], crank),
        Length(("L_f",), fixed[1], follower),
        Angle(("crank_deg",), fixed[0], 0, direction(fixed[0], crank), 0.1 * size),
        Angle.between(("transmission_deg",), follower, crank, fixed[1], 0.15 * size),
    ]
    return Sheet("linkage", f"linkage of dyads {linkage.numbers[0]} and {linkage.numbers[1]} in the last pose but one",
                 still("linkage", bodies), marks)  # fmt: skip


def _train(training: Training) -> Sheet:
    """The four pitch curves on the carrier at its first angle."""
    hinges = MM * centres(training).T
    curves = [Outline(points.T + hinges[at], "gear", shade=k)
              for k, (points, at) in enumerate(zip(outlines(training), _HINGES, strict=True))]  # fmt: skip
    carrier = Outline(hinges, "frame", closed=False)
    radii = training.train.gears(np.array([training.train.curve.carrier[0]]))
    marks: list[Mark] = [Length(("centre_distance_mm",), hinges[0], hinges[1], 0.8)]
    for stage, names in enumerate((("r1", "r2"), ("r3", "r4"))):
        columns = [f"{gear}_{stage + 1}_radius_mm" for gear in ("driver", "follower")]
        ends = hinges[stage], hinges[stage + 1]
        share = float(radii[names[0]][0]) / training.train.distance
        contact = (1 - share) * ends[0] + share * ends[1]
        marks += [Length((name,), end, contact) for name, end in zip(names, ends, strict=True)]
        marks += [Length((name,), end, contact, 0.8) for name, end in zip(columns, ends, strict=True)]
    if training.crank is not None:
        radius = 0.3 * MM * training.train.distance
        marks.append(Length(("L1",), hinges[0], hinges[2], 0.3))
        marks.append(Angle.between(("bend",), hinges[1], hinges[0], hinges[2], radius))
    return Sheet("train", "gear train on its carrier, bent as its length wants", still("train",
                 (Body("gears", curves), Body("carrier", (carrier,)))), marks)  # fmt: skip
