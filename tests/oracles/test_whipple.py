"""The Whipple bicycle against the benchmark of Meijaard, Papadopoulos, Ruina and Schwab, Proc.

R. Soc. A 463 (2007).

M, C1, K0, K2 of its equations (5.3)-(5.4) in lean and steer, eigenvalues of its table 2 at speeds
of 0 to 10 m/s.
"""

import numpy as np
import pytest
from scipy.linalg import expm

from planter.mechanism.dynamics import Dynamics
from planter.mechanism.motion import LinearisedMotion, linearise
from tests.support import own

M = [[80.81722, 2.31941332208709], [2.31941332208709, 0.29784188199686]]
C1 = [[0, 33.86641391492494], [-0.85035641456978, 1.68540397397560]]
K0 = [[-80.95, -2.59951685249872], [-2.59951685249872, -0.80329488458618]]
K2 = [[0, 76.59734589573222], [0, 2.65431523794604]]
WEAVE = [
    3.52696170990070 + 0.80774027519930j,
    2.68234517512745 + 1.68066296590675j,
    1.70675605663975 + 2.31582447384325j,
    0.41325331521125 + 3.07910818603206j,
    -0.77534188219585 + 4.46486771378823j,
    -1.52644486584142 + 5.87673060598709j,
    -2.13875644258362 + 7.19525913329805j,
    -2.69348683581097 + 8.46037971396931j,
    -3.21675402252485 + 9.69377351531791j,
    -3.72016840437287 + 10.90681139476287j,
]
CAPSIZE = [
    -3.13423125066578,
    -3.07158645641514,
    -2.63366137253667,
    -1.42944427361326,
    -0.32286642900409,
    -0.00406690076970,
    0.10268170574766,
    0.14327879765713,
    0.15790184030917,
    0.16105338653172,
]
CASTERING = [
    -7.11008014637442,
    -8.67387984831735,
    -10.35101467245920,
    -12.15861426576447,
    -14.07838969279822,
    -16.08537123098026,
    -18.15788466125262,
    -20.27940894394569,
    -22.43788559040858,
    -24.62459635017404,
]
STANDING = [5.53094371765393, 3.13164324790656, -3.13164324790656, -5.53094371765393]
GRAVITY = 9.81


def bicycle(speed: float, **values: float) -> Dynamics:
    return own.dynamics("whipple", v_m_s=speed, **values)


def about(speed: float, **values: float) -> LinearisedMotion:
    """Small motions about steady riding; lean and steer come first."""
    dynamics = bicycle(speed, **values)
    names = dynamics.names[: dynamics.size]
    free = ["lean", "steer", "rear_spin"]
    places = ["lean", "steer", *(n for n in names if n not in ("lean", "steer", "z", "pitch"))]
    return linearise(dynamics, dynamics.start(), free, places)


def test_the_matrices_are_those_in_print() -> None:
    still, slow, fast = about(0.0), about(1.0), about(10.0)
    assert own.deviation("M", still.inertia[:2, :2], M) < 1e-12
    assert own.deviation("C1", slow.damping[:2, :2], C1) < 1e-12
    assert own.deviation("K0", still.stiffness[:2, :2] / GRAVITY, K0) < 1e-12
    assert own.deviation("K2", (fast.stiffness[:2, :2] - still.stiffness[:2, :2]) / 100, K2) < 1e-12
    assert own.deviation("damping at rest", still.damping[:2, :2], np.zeros((2, 2))) < 1e-12


def test_trail_error_of_a_micrometre_is_detected() -> None:
    assert np.abs(about(0.0, c_m=0.080001).inertia[:2, :2] - M).max() > 1e-6


@pytest.mark.parametrize("speed", range(11))
def test_eigenvalues_are_those_in_print(speed: int) -> None:
    """Those of lean and steer: what can be ignored (place, course, turns of the wheels, speed) has
    zeros.
    """
    motion = about(float(speed))
    eigenvalues = np.linalg.eigvals(
        np.block(
            [
                [np.zeros((2, 2)), np.eye(2)],
                [
                    -np.linalg.solve(
                        motion.inertia[:2, :2],
                        np.hstack([motion.stiffness[:2, :2], motion.damping[:2, :2]]),
                    )
                ],
            ]
        )
    )
    if speed:
        weave = WEAVE[speed - 1]
        printed = [weave, weave.conjugate(), CAPSIZE[speed - 1], CASTERING[speed - 1]]
    else:
        printed = list(STANDING)
    size = np.abs(printed).max()
    nearest = [
        eigenvalues[np.argmin(np.abs(eigenvalues - printed_value))] for printed_value in printed
    ]
    assert own.deviation(f"eigenvalues at {speed} m/s", nearest, printed) < 1e-12 * size
    computed = motion.eigenvalues()
    assert max(np.abs(computed - printed_value).min() for printed_value in printed) < 1e-9 * size


def test_ignored_coordinate_has_no_influence() -> None:
    at = about(5.0)
    assert at.stiffness[:, 2:] == pytest.approx(0, abs=1e-10)
    assert at.damping[:2, 2] == pytest.approx(0, abs=1e-10)


def test_a_small_push_dies_away_as_small_motions_say() -> None:
    """Stable from 4.29 to 6.02 m/s: after a small lean rate at 5 m/s lean follows the linear
    motion; energy stays.
    """
    dynamics, push = bicycle(5.0), 1e-4
    start, lean = dynamics.start(), dynamics.names.index("lean")
    start[dynamics.size + lean] = push
    times = np.linspace(0, 4, 41)
    run = dynamics.run(times, 1e-10, start)
    small = about(5.0)
    pulls = -np.linalg.solve(small.inertia, np.hstack([small.stiffness, small.damping]))
    flow = np.vstack([np.hstack([small.drift, small.speeds]), pulls])
    pushed = run.states[dynamics.size :, 0] - dynamics.start()[dynamics.size :]
    first = np.zeros(len(flow))
    first[len(small.drift) :] = [
        pushed[dynamics.names.index(name)] for name in ("lean", "steer", "rear_spin")
    ]
    expected = [(expm(flow * time) @ first)[0] for time in times]
    assert (
        own.deviation("lean, over the push", run.states[lean] / push, np.array(expected) / push)
        < 1e-5
    )
    assert np.abs(run.states[lean, -5:]).max() < 0.2 * np.abs(run.states[lean]).max()
    energy = run.results["kinetic"] + run.results["potential"]
    assert own.deviation("energy", energy, energy[0]) < 1e-8 * energy[0]
