"""Boxes bounded by workers: the same proof as here, whatever their number."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from planter.engine.proof.proof_results import GlobalBound
from planter.engine.proof.search import Incumbent, SharedObjective, prove_bound
from planter.task import AUTO, Means
from tests.planter.engine.proof.toys import BEST, Ring

BOX = np.array([-1.5, -1.0]), np.array([1.2, 1.3])


def prove(means: Means) -> GlobalBound:
    objective = float((BEST @ BEST - 1) ** 2 + 0.1 * BEST[0])
    incumbent = Incumbent(BEST, {"x": float(BEST[0]), "y": 0.0}, objective, 1)
    with SharedObjective(Ring(), Ring, means) as shared:
        return replace(prove_bound(shared, BOX, incumbent, seconds=60.0).result, seconds=0.0)


@pytest.mark.fault
def test_number_of_workers_changes_no_digit() -> None:
    serial = prove(AUTO)
    assert serial.proved
    assert serial.boxes > 100
    assert prove(Means(1)) == prove(Means(2)) == serial
