"""Teeth on hollow curves that run into fillets: racks that are offered for them pass, those beside them do not."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from planter.errors import GeometryError
from planter.gearing.stage import Stage
from planter.gearing.teeth import remedies
from planter.gearing.teeth.making import Toothed, toothed
from planter.gearing.teeth.pair import of_stage
from tests.support import pairs
from tests.support.toothed import FREE, circles


def hollow(eccentricity: float, teeth: int) -> Toothed:
    """A deformed eccentric circle that is hollow on either side."""
    own = np.array([0.031, eccentricity, 1.9])
    stage: Stage = pairs.stage_of("eccentric_circle", own)
    return toothed(of_stage(stage, own), replace(FREE, teeth=teeth), "pair", ("gear", "mate"))


def test_the_racks_that_are_offered_pass_and_a_hundredth_less_does_not() -> None:
    found = hollow(0.012, 31)
    with pytest.raises(GeometryError, match=r"run into each other by .* mm2 at the polar angle .* would do$") as told:
        remedies.check_overlap(found)
    first, clearance, second = map(float, re.findall(r"(?:radius|clearance) of ([\d.]+)", str(told.value)))
    offered = [replace(FREE, tip_radius=first), replace(FREE, clearance=clearance, tip_radius=second)]
    short = [replace(FREE, tip_radius=first + 0.01), replace(offered[1], clearance=clearance - 0.01)]
    assert second == 0.37
    assert [remedies.passes(found, order) for order in (*offered, *short)] == [True, True, False, False]


def test_what_no_rack_clears_is_said_to_be_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(remedies, "DEEPEST", 0.3)
    assert remedies.advice(hollow(0.015, 41)).startswith("no smaller round on the tips of the rack and no clearance")


def test_teeth_that_pass_need_none() -> None:
    remedies.check_overlap(circles(31, 31, FREE))
