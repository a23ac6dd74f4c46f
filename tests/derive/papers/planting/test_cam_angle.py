"""The cam's pressure angle by the roller's path on the cam and on the planet, drawn point by
point.
"""

import math

import numpy as np
import pytest

from planter.kernels.formulas import load
from tests.support import machines

CAM = load("planting_cam")
STEP = 1e-6
Place = tuple[float, float, float]


def roller(c: dict[str, float], theta1: float) -> np.ndarray:
    """Roller in the planet's frame, from B1: turned about the hinge, whose axis is y'."""
    x, z = -c["L_AE"] * math.cos(c["psi0"]), c["L_AE"] * math.sin(c["psi0"])
    cosine, sine = math.cos(theta1), math.sin(theta1)
    return np.array([c["x_A"] + cosine * x + sine * z, c["R_b"], c["z_A"] - sine * x + cosine * z])


@pytest.mark.parametrize("slope", [-0.8, 0.0, 0.4, 1.1])
@pytest.mark.parametrize("theta1", [0.0, 0.2])
def test_pressure_angle_of_roller_path(theta1: float, slope: float) -> None:
    """`slope` is the swing per turn of planet on carrier; the path counts in the plane of the
    swing, x' and z'.
    """
    c = dict(zip(CAM.entries("machine"), machines.device("wang2017").constants, strict=True))
    turn = np.array(
        [[math.cos(STEP), -math.sin(STEP), 0], [math.sin(STEP), math.cos(STEP), 0], [0, 0, 1]]
    )
    centre = roller(c, theta1)
    path = (turn @ roller(c, theta1 + slope * STEP) - centre)[[0, 2]] / STEP
    way = (roller(c, theta1 + STEP) - centre)[[0, 2]] / STEP
    normal = np.array([-path[1], path[0]])
    expected = math.acos(min(abs(normal @ way) / np.linalg.norm(normal) / np.linalg.norm(way), 1.0))
    rates = {"theta1_dot": 3.0 * slope, "Omega": c["omega"] + 3.0}
    angle = CAM.at("cam", theta1=theta1, machine=list(c.values()), **rates)["pressure"]
    assert abs(angle) == pytest.approx(expected, abs=1e-5)
    steeper = CAM.at(
        "cam", theta1=theta1, machine=list(c.values()), **{**rates, "theta1_dot": 3 * slope + 1.5}
    )
    assert abs(steeper["pressure"]) != pytest.approx(expected, abs=1e-3)
