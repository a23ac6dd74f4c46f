"""Mechanisms of many coordinates: closed loops by circles, forces by virtual power, accelerations
by Pinocchio.
"""

from __future__ import annotations

import json
import time
from functools import cache
from pathlib import Path
from tempfile import mkdtemp

import casadi as ca
import numpy as np
import pytest
import scipy.integrate
from numpy.typing import NDArray

from derive.emit.folder import built_in, emit_system, select_targets
from planter import paths
from planter.errors import InputError
from planter.kernels.formulas import HOISTED
from planter.mechanism.dynamics import Dynamics
from planter.mechanism.file import load
from planter.mechanism.machines import build_machine
from planter.text_files import MOST_VALUES, check_values
from tests.planter.exports.exported import Library
from tests.planter.mechanism.state_space.statements import build_chain, build_tree
from tests.support import own
from tests.support.cli import answer

STATEMENTS = Path(__file__).parent / "large"
LINKS = 20
Vector = NDArray[np.float64]


def statement(name: str) -> str:
    return (STATEMENTS / f"{name}.txt").read_text(encoding="utf-8")


def meet(first: Vector, r: float, second: Vector, s: float, guess: Vector) -> Vector:
    """The point where two circles meet, of the two the one near another point."""
    line = second - first
    distance = float(np.hypot(*line))
    offset = (distance**2 + r**2 - s**2) / (2 * distance)
    across = np.sqrt(r**2 - offset**2)
    middle, normal = first + offset / distance * line, np.array([-line[1], line[0]]) / distance
    return min(
        (middle + side * across * normal for side in (1, -1)),
        key=lambda point: float(np.hypot(*(point - guess))),
    )


@pytest.mark.parametrize("crank_mm", [15.0, 13.2])
def test_leg_of_ten_loop_coordinates_moves_as_circles_meet(crank_mm: float) -> None:
    file = own.file(statement("jansen"), "jansen", mm_mm=crank_mm)
    angles = np.linspace(0, 2 * np.pi, 25)
    got = own.evaluate_lane(file, angles)
    a, b, c, d, e, f, g, h, i, j, k, level = (
        file.si(f"{name}_mm")
        for name in ("a", "b", "c", "d", "e", "f", "gg", "h", "i", "j", "k", "l")
    )
    for n, phi in enumerate(angles):

        def place_end(start: Vector, length: float, name: str, n: int = n) -> Vector:
            direction = got[f"t_{name}"][n]
            return start + length * np.array([np.cos(direction), np.sin(direction)])

        crank = crank_mm * 1e-3 * np.array([np.cos(phi), np.sin(phi)])
        fixed = np.array([-a, -level])
        upper = meet(crank, j, fixed, b, place_end(fixed, b, "b"))
        left = meet(upper, e, fixed, d, place_end(fixed, d, "d"))
        lower = meet(crank, k, fixed, c, place_end(fixed, c, "c"))
        knee = meet(left, f, lower, g, place_end(lower, g, "g"))
        foot = meet(knee, h, lower, i, place_end(lower, i, "i"))
        assert (got["x_S"][n], got["y_S"][n]) == pytest.approx(foot, abs=1e-12)


def test_array_code_and_c_agree_in_any_order_of_elimination() -> None:
    """Five loops in C, one after the other; the same steps with NumPy."""
    file = own.file(statement("jansen"), "jansen")
    angles = np.linspace(0.1, 6.2, 7)
    expected = own.evaluate_lane(file, angles)
    library = Library(
        [Path(path) for path in answer("export", "c", file.source, "--out", mkdtemp())["files"]]
    )
    status, rows = library.quantities(angles)
    assert status == 0
    places = build_machine(file).loops.course(file.name, file.data()).evaluate(angles)
    module = own.array_code(statement("jansen"), "jansen")
    lane = module.lane(np, angles, file.data(), places, module.prologue(np, file.data()))
    names = file.model.outputs("lane")
    for name in ("x_S", "y_S", "t_h_dot", "t_h_ddot"):
        assert rows[library.names.index(name)] == pytest.approx(
            expected[name], rel=1e-11, abs=1e-13
        )
        assert lane[names.index(name)] == pytest.approx(expected[name], rel=1e-11, abs=1e-13)


def test_loops_that_close_alone_are_closed_alone() -> None:
    loops = own.machine(statement("jansen"), "jansen").loops
    assert loops is not None
    assert (loops.size, loops.count) == (10, 5)
    assert loops.steps_function.n_instructions() < 10_000


def test_gradient_through_loops_keeps_the_law_of_similarity() -> None:
    """A length is a homogeneous function of all lengths: their slopes times themselves add up to it
    (Euler).
    """
    path = own.generated(statement("jansen")) / "jansen.toml"
    result = answer("sensitivity", str(path), "--least", "max x_S", "--all")
    lengths = {key: slope for key, slope in result["gradient"].items() if key.endswith("_mm")}
    file = load(path)
    weighted = sum(slope * file.si(key) * 1e3 for key, slope in lengths.items())
    assert len(lengths) == 13
    assert weighted == pytest.approx(result["objective"], rel=1e-9)
    assert result["objective"] == pytest.approx(-3.6133, abs=1e-3), "by circles, of all assemblies"


FORCES = {
    0: (-13.61599282, -64.25016172, -41.05406336, -16.18687275, -61.62750261, -36.23495392),
    30: (-44.58060968, -78.84456798, -39.83765145, -7.73163677, -17.53970391, -50.02547039),
    100: (-102.37965033, -81.1338602, -49.32026598, -30.27711632, 38.04576155, -73.62882755),
}
"""Forces of the legs of a platform [N] at angles [deg]: virtual power, positions differentiated
numerically.
"""


def test_platform_of_eighteen_loop_coordinates_carries_its_legs() -> None:
    start = time.process_time()
    path = own.generated(statement("stewart")) / "stewart.toml"
    at = [word for angle in FORCES for word in ("--at", str(angle))]
    result = answer("simulate", str(path), *at)
    for entry, forces in zip(result["at"], FORCES.values(), strict=True):
        assert [entry[f"F{k}_N"] for k in range(6)] == pytest.approx(forces, rel=1e-6)
    assert time.process_time() - start < 60, "a tampered order of elimination takes minutes"


def test_order_of_elimination_keeps_the_platform_small() -> None:
    """Sixty reactions, and eighteen coordinates four times: in the order of the statement it has
    55,000 operations.
    """
    lane = own.file(statement("stewart"), "stewart").model.function("lane")
    assert HOISTED in lane.name_in()
    assert lane.n_instructions() < 30_000


@cache
def chain() -> Dynamics:
    return own.dynamics(build_chain(LINKS), "own")


@pytest.mark.parametrize("links", [3, 24, 50])
def test_accelerations_of_a_chain_agree_with_pinocchio(links: int) -> None:
    pin = pytest.importorskip("pinocchio")
    dynamics = own.dynamics(build_chain(links), "own")
    tree, rng = build_tree(links), np.random.default_rng(1)
    data, accelerate = tree.createData(), dynamics._bind_accelerations(1e-9)
    for _ in range(20):
        q, rates = rng.uniform(-np.pi, np.pi, links), rng.normal(size=links)
        expected = pin.aba(tree, data, q, rates, np.zeros(links))
        error = np.abs(accelerate(0.0, np.r_[q, rates]) - expected).max()
        assert error <= 1e-13 * np.abs(expected).max()


def test_derivation_of_a_chain_grows_as_its_links() -> None:
    """Text, operations and time; expressions that are multiplied out grow as their square or more."""
    texts = {}
    for links, most_s in ((12, 2), (24, 4), (50, 12)):
        start, stated = time.process_time(), {}
        exec(build_chain(links), stated)
        texts[links] = emit_system(stated["SYSTEM"], select_targets(built_in()))
        assert time.process_time() - start < most_s
    assert len(texts[50]["own.py"].encode()) <= 250_000
    operations = {
        links: json.loads(text["own.json"])["functions"]["accelerations"]["operations"]
        for links, text in texts.items()
    }
    assert operations[50] <= 2.2 * operations[24]


def test_motion_of_a_chain_needs_as_many_evaluations_as_pinocchio(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Noise of the accelerations would make the integrator's steps short."""
    pin = pytest.importorskip("pinocchio")
    tree, tolerance, counts = build_tree(LINKS), 1e-10, {"own": 0, "pinocchio": 0}
    data, bind = tree.createData(), Dynamics._bind_accelerations

    def count(self: Dynamics, share: float) -> object:
        accelerate = bind(self, share)

        def counted(at: float, state: Vector) -> Vector:
            counts["own"] += 1
            return accelerate(at, state)

        return counted

    def differentiate(_: float, state: Vector) -> Vector:
        counts["pinocchio"] += 1
        return np.r_[
            state[LINKS:], pin.aba(tree, data, state[:LINKS], state[LINKS:], np.zeros(LINKS))
        ]

    monkeypatch.setattr(Dynamics, "_bind_accelerations", count)
    motion = chain().run(np.linspace(0, 1, 201), tolerance)
    solver = scipy.integrate.DOP853(
        differentiate, 0.0, np.zeros(2 * LINKS), 1.0, rtol=tolerance, atol=1e-2 * tolerance
    )
    while solver.status == "running":
        solver.step()
    assert counts["own"] <= 1.2 * counts["pinocchio"]
    assert np.degrees(motion.states[0, -1]) == pytest.approx(-67.5475, abs=1e-4)
    assert np.degrees(solver.y[0]) == pytest.approx(-67.5475, abs=1e-4)


def test_noisy_accelerations_would_be_noticed() -> None:
    """A tampered case: CasADi's own solution of the same equations loses the digits that count."""
    pin = pytest.importorskip("pinocchio")
    tree, rng = build_tree(LINKS), np.random.default_rng(1)
    inputs = chain().function.sx_in()
    inertia, forces, *_ = chain().function(*inputs)
    solved = ca.Function("noisy", inputs[:2], [ca.solve(inertia, forces)])
    q, rates = rng.uniform(-np.pi, np.pi, LINKS), rng.normal(size=LINKS)
    expected = pin.aba(tree, tree.createData(), q, rates, np.zeros(LINKS))
    error = np.abs(np.asarray(solved(0.0, np.r_[q, rates]))[:, 0] - expected).max()
    assert error > 1e-10 * np.abs(expected).max()


def test_files_that_planter_wrote_have_no_limit_of_values() -> None:
    """The sidecar of seventy bodies holds more than a file of a user's may."""
    text = statement("nlink")
    sidecar = own.generated(text) / "nlink70.json"
    content = json.loads(sidecar.read_text(encoding="utf-8"))
    assert len(list(paths.walk_locations(content))) > MOST_VALUES
    with pytest.raises(InputError, match=str(MOST_VALUES)):
        check_values(content, "a tampered case: a file of a user's")
    result = answer("move", str(sidecar.with_suffix(".toml")), "--until", "0.05", "--points", "3")
    energy = result["energy"]
    assert energy["most_J"] <= energy["start_J"] + 1e-9, "friction alone takes energy"
