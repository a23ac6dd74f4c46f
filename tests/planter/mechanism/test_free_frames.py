"""Bodies that turn in any way in space, held against elliptic functions (Landau and Lifshitz,
Mechanics, 35 and 37).
"""

from typing import Any

import numpy as np
import pytest
import scipy.special
from scipy.spatial.transform import Rotation

from derive import Mechanism, X
from derive.mechanics.statement import MechanismError
from derive.quantity import Quantity
from planter.kernels import Array
from planter.mechanism.dynamics import MotionRun
from tests.support import own

STONE = '''
from derive import Mechanism, X, Y, quantities
q = quantities("""
    g | m/s2  | free fall | 9.81
    m | kg    | stone     | 0.4
    A | kg m2 | x         | 3e-4
    B | kg m2 | y         | 5e-4
    C | kg m2 | z         | 6e-4
    a | rad   | first turn at the start | 0
    b | rad   | second turn at the start | 0
    u | rad/s | spin about x | 6
    w | rad/s | spin about z | 4
""")
m = Mechanism("stone", q, gravity=(0, 0, -q.g), spatial=True)
place = [m.coordinate(axis, "m", axis) for axis in "xyz"]
turned = m.free_frame("stone", start=[(X, q.a), (Y, q.b)], spin=(q.u, 0, q.w))
m.body("stone", turned, q.m, m.point("C", m.O, m.world, *place), (q.A, q.B, q.C))
SYSTEM = m.system()
'''
MOMENTS = np.array([3e-4, 5e-4, 6e-4])
TIMES = np.linspace(0.0, 6.0, 121)


def throw(**values: float) -> MotionRun:
    return own.dynamics(STONE, "stone", **values).run(TIMES)


def get_spins(run: MotionRun, name: str) -> Array:
    return np.array([run.results[f"spin_{name}{axis}"] for axis in "xyz"])


def compute_spins(u: float, w: float, moments: Array = MOMENTS) -> Array:
    """Angular velocities (3, n) of a free body whose spin about its middle axis is zero at the
    start.
    """
    first, second, third = moments
    energy2, momentum2 = first * u**2 + third * w**2, (first * u) ** 2 + (third * w) ** 2
    assert momentum2 > energy2 * second
    low, high = energy2 * third - momentum2, momentum2 - energy2 * first
    pace = np.sqrt((third - second) * high / (first * second * third))
    sn, cn, dn, _ = scipy.special.ellipj(
        pace * TIMES, (second - first) * low / ((third - second) * high)
    )
    return np.array(
        [
            np.sqrt(low / (first * (third - first))) * cn,
            np.sqrt(low / (second * (third - second))) * sn,
            np.sqrt(high / (third * (third - first))) * dn,
        ]
    )


def test_thrown_body_tumbles_as_elliptic_functions_say() -> None:
    spins = get_spins(throw(u_rad_s=6.0, w_rad_s=7.0), "stone")
    expected = compute_spins(6.0, 7.0)
    assert np.abs(spins - expected).max() < 1e-7
    assert np.abs(spins - compute_spins(6.0, 7.0, MOMENTS * [1, 1.001, 1])).max() > 1e-3


@pytest.mark.parametrize(
    ("first", "second"), [(0.0, np.pi / 2), (np.pi / 2, np.pi / 2), (2.0, -1.1), (np.pi, np.pi)]
)
def test_no_attitude_at_the_start_is_singular(first: float, second: float) -> None:
    run = throw(a_rad=first, b_rad=second, u_rad_s=6.0, w_rad_s=7.0)
    assert np.abs(get_spins(run, "stone") - compute_spins(6.0, 7.0)).max() < 1e-7
    start = Rotation.from_euler("XY", [first, second]).as_quat()[[3, 0, 1, 2]]
    assert run.states[3:7, 0] == pytest.approx(start, abs=1e-12)


def test_angular_momentum_keeps_its_direction_in_space() -> None:
    run = throw(a_rad=1.0, b_rad=-2.0)
    attitudes = Rotation.from_quat(run.states[[4, 5, 6, 3]].T)
    momenta = attitudes.apply((MOMENTS[:, None] * get_spins(run, "stone")).T)
    assert np.abs(momenta - momenta[0]).max() < 1e-7 * np.abs(momenta).max()
    assert np.linalg.norm(run.states[3:7], axis=0) == pytest.approx(1, abs=1e-12)
    height = run.states[2]
    assert height == pytest.approx(-9.81 * TIMES**2 / 2, rel=1e-9, abs=1e-9)
    assert np.ptp(run.results["kinetic"] + run.results["potential"]) < 1e-7


def test_heavy_top_nods_as_elliptic_functions_say() -> None:
    """Released level, with spin about its axis: Lagrange's top, whose cosine of the lean is an
    elliptic function.
    """
    run = own.dynamics("spinning_top").run(TIMES / 6)
    transverse, axial, weight, arm, spin = 4e-4 + 0.5 * 0.06**2, 6e-4, 0.5 * 9.81, 0.06, 120.0
    beta, a = 2 * weight * arm / transverse, axial * spin / transverse
    low, high = sorted(np.roots([1, -(a**2) / beta, -1]))
    pace, modulus = np.sqrt(beta * (high - low)) / 2, -low / (high - low)
    sn = scipy.special.ellipj(scipy.special.ellipk(modulus) + pace * run.times, modulus)[0]
    assert run.results["height"] / arm == pytest.approx(low * (1 - sn**2), abs=1e-8)
    assert run.results["spin_topz"] == pytest.approx(spin, rel=1e-9)
    assert run.results["F_Jz"][0] == pytest.approx(
        weight * (1 - 0.5 * arm**2 / transverse), rel=1e-9
    )


def test_free_frame_is_refused_in_the_plane_and_along_an_angle() -> None:
    with pytest.raises(MechanismError, match=r"stone.*space"):
        Mechanism("plane").free_frame("stone")
    phi, omega = (
        Quantity("phi", "rad", "crank", "test"),
        Quantity("omega", "rad/s", "speed", "test"),
    )
    with pytest.raises(MechanismError, match=r"stone.*free motion"):
        Mechanism("driven", angle=phi, speed=omega, spatial=True).free_frame("stone")


def test_start_that_is_no_list_of_turns_is_refused() -> None:
    length = Quantity("l", "m", "arm", "test")
    starts: tuple[Any, ...] = ([(X, length)], [X])
    for start in starts:
        with pytest.raises(MechanismError, match=r"stone.*start"):
            Mechanism("own", spatial=True).free_frame("stone", start=start)
    with pytest.raises(MechanismError, match=r"stone.*spin"):
        Mechanism("own", spatial=True).free_frame("stone", spin=(0, 1))
