"""Andrews' squeezing mechanism against the numbers of the test set for initial value problems.

F. Mazzia, C. Magherini, "Test Set for Initial Value Problem Solvers", release 2.4, University of
Bari 2008, problem ANDREWS: consistent initial values, and the reference solution at 0.03 s. Its
multipliers pull the other way round.
"""

import numpy as np
import pytest
from mpmath import mp
from scipy.integrate import solve_ivp

from tests.support import own, xp_mpmath

START = """-0.0617138900142764496358948458001 0 0.455279819163070380255912382449 0.222668390165885884674473185609
0.487364979543842550225598953530 -0.222668390165885884674473185609 1.23054744454982119249735015568"""
ACCELERATIONS = "14222.4439199541138705911625887 -10666.8329399655854029433719415 0 0 0 0 0"
MULTIPLIERS = "98.5668703962410896057654982170 -6.12268834425566265503114393122 0 0 0 0"
END = np.array(
    [
        15.81077119629904,
        -15.75637105984298,
        0.04082224013073101,
        -0.5347301163226948,
        0.5244099658805304,
        0.5347301163226948,
        1.048080741042263,
    ]
)


def exact(data: list[object]) -> tuple[list[object], list[object]]:
    """Accelerations and multipliers at the start, at the working precision of mpmath."""
    code = own.array_code("andrews")
    model = own.file("andrews").model
    state = [*map(mp.mpf, START.split()), *[mp.mpf(0)] * 7]
    names, multipliers = model.outputs("start")[:7], [name[6:] for name in model.outputs("speeds")]
    values: dict[str, object] = {}
    for stage in ("slopes", "bends"):
        if stage in model.sidecar["functions"]:
            entries = getattr(code, stage)(xp_mpmath, mp.mpf(0), data, state)
            values |= dict(zip(model.outputs(stage), entries, strict=True))
    units = mp.eye(7)
    rest, *moved = (
        code.residual(xp_mpmath, mp.mpf(0), data, state, accelerations)
        for accelerations in ([mp.mpf(0)] * 7, *(list(units.column(j)) for j in range(7)))
    )
    matrix, right = mp.matrix(13, 13), mp.matrix(13, 1)
    for i, a in enumerate(names):
        right[i] = -rest[i]
        for j, residual in enumerate(moved):
            matrix[i, j] = residual[i] - rest[i]
        for j, c in enumerate(multipliers, 7):
            slope = values.get(f"slope_{c}_{a}", 0)
            matrix[i, j], matrix[j, i] = -slope, slope
    for j, c in enumerate(multipliers, 7):
        right[j] = values.get(f"bend_{c}", 0)
    solution = list(mp.lu_solve(matrix, right))
    return solution[:7], solution[7:]


def as_written() -> list[object]:
    """The data as the file has them, none of them rounded to a double."""
    values = own.file("andrews").values
    return [mp.mpf(repr(value)) for value in values.values()]


def test_accelerations_and_multipliers_have_all_digits_in_print() -> None:
    with mp.workdps(40):
        accelerations, multipliers = exact(as_written())
        for acceleration, printed in zip(
            [*accelerations, *[-m for m in multipliers]],
            f"{ACCELERATIONS} {MULTIPLIERS}".split(),
            strict=True,
        ):
            print(f"found {mp.nstr(acceleration, 30)}, printed {printed}")
            assert abs(acceleration - mp.mpf(printed)) <= mp.mpf("1e-27") * max(
                1, abs(mp.mpf(printed))
            )


def test_error_in_last_digit_is_detected() -> None:
    with mp.workdps(40):
        data = as_written()
        data[0] += mp.mpf("1e-5")
        assert abs(exact(data)[0][0] - mp.mpf(ACCELERATIONS.split()[0])) > 1e-2


def test_doubles_have_theirs() -> None:
    dynamics = own.dynamics("andrews")
    accelerations, multipliers = dynamics.accelerations(0.0, dynamics.start())
    assert accelerations == pytest.approx(
        np.array(ACCELERATIONS.split(), float), rel=1e-13, abs=1e-9
    )
    assert -multipliers == pytest.approx(np.array(MULTIPLIERS.split(), float), rel=1e-13, abs=1e-11)


def test_the_angles_at_the_end_are_those_of_the_reference() -> None:
    """Over their size: beta and Theta are near 16 rad."""
    run = own.dynamics("andrews").run(np.array([0.0, 0.03]), 1e-12)
    size = np.maximum(1, np.abs(END))
    assert (
        own.deviation("seven angles over their size", run.states[:7, -1] / size, END / size) < 1e-9
    )


def test_remaining_error_equals_reference() -> None:
    """Without projection, at the least tolerance there is, the angles are the same to a hundredth
    of the deviation.
    """
    dynamics = own.dynamics("andrews")

    def rates(time: float, state: np.ndarray) -> np.ndarray:
        return np.concatenate([state[7:], dynamics.accelerations(time, state)[0]])

    free = solve_ivp(rates, (0, 0.03), dynamics.start(), method="DOP853", rtol=3e-14, atol=1e-16).y[
        :7, -1
    ]
    final_state = dynamics.run(np.array([0.0, 0.03]), 1e-12).states[:7, -1]
    assert own.deviation("with and without projection", final_state, free) < 1.5e-11
    assert own.deviation("without projection, from the reference", free, END) < 2e-9


def test_joint_forces_balance_every_body() -> None:
    """At the start crank and rod lie in line; momentum of all bodies follows from the forces of the
    ground alone.
    """
    run = own.dynamics("andrews").run(np.linspace(0, 0.01, 5), 1e-11)
    masses = own.file("andrews").values
    assert run.undetermined == ()
    for axis in "xy":
        outer = sum(run.results[f"F_{pin}{axis}"] for pin in ("O", "B", "A5", "A7"))
        moved = sum(masses[f"m{i}_kg"] * run.results[f"a_K{i}_{axis}"] for i in range(1, 8))
        assert outer == pytest.approx(moved - spring(run.states, axis), abs=1e-9)


def spring(states: np.ndarray, axis: str) -> np.ndarray:
    """Force of the spring on the mechanism, from the angle of its bar alone."""
    v, gamma = own.file("andrews").values, states[2]
    x = v["xb_m"] + v["sd_m"] * np.cos(gamma) + v["sc_m"] * np.sin(gamma) - v["xc_m"]
    y = v["yb_m"] + v["sd_m"] * np.sin(gamma) - v["sc_m"] * np.cos(gamma) - v["yc_m"]
    long = np.hypot(x, y)
    return -v["c0_N_m"] * (long - v["l0_m"]) / long * (x if axis == "x" else y)
