"""The nozzle in the soil: its axis on a line through the tip, and the nearest point of a half by
looking everywhere.
"""

import math

import numpy as np
import pytest

from planter.kernels.formulas import Formulas, load
from tests.support import machines

NOZZLE: Formulas = load("planting_nozzle")
RNG = np.random.default_rng(4)


@pytest.mark.parametrize("alpha", [1.1, math.pi / 2, 1.9])
def test_the_axis_passes_the_soil_on_the_line_through_the_tip(alpha: float) -> None:
    axis = NOZZLE.at("axis", x_tip=0.3, y_tip=-0.2, alpha=alpha, soil=-0.13)
    assert axis["tilt"] == pytest.approx(alpha - math.pi / 2)
    direction = np.array([math.cos(alpha), -math.sin(alpha)])
    to_soil = np.array([axis["cut"] - 0.3, -0.13 + 0.2])
    assert abs(direction[0] * to_soil[1] - direction[1] * to_soil[0]) < 1e-15
    assert NOZZLE.at("axis", x_tip=0.3, y_tip=-0.2, alpha=1.1, soil=-0.12)["cut"] != pytest.approx(
        axis["cut"]
    )


def test_clearance_of_half_below_the_plant() -> None:
    constants = dict(
        zip(NOZZLE.entries("machine"), machines.device("wang2017").constants, strict=True)
    )
    hinge, tip = constants["x_A"], constants["L_tip"]
    seen = set()
    for _ in range(60):
        x, y, plant, top = RNG.uniform(-0.05, 0.05, 4)
        alpha, theta1 = RNG.uniform(1.2, 1.9), RNG.uniform(0, 0.35)
        pose = {"x_tip": x, "y_tip": y, "alpha": alpha, "theta1": theta1}
        geometry = {
            "plant": plant,
            "top": y + abs(top),
            "hair": 1e-9,
            "machine": list(constants.values()),
        }
        clearance = NOZZLE.at("half", **pose, **geometry)["clearance"]
        s = np.linspace(0, tip - hinge, 40001)
        direction = np.array([math.cos(alpha), -math.sin(alpha)])
        points = (
            np.array([x, y])[:, None]
            + (hinge - tip) * direction[:, None]
            + s * math.cos(theta1) * direction[:, None]
        )
        distance = np.hypot(points[0] - plant, s * math.sin(theta1))
        low = points[1] <= y + abs(top) + 1e-12
        if low.any():
            assert clearance == pytest.approx(distance[low].min(), abs=2e-5)
            seen.add(round(clearance, 4) == round(distance.min(), 4))
    assert seen == {True, False}
