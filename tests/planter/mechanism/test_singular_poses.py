"""Poses in which more constraints depend on each other: passed on the same branch, or told."""

import numpy as np
import pytest

from planter import errors
from planter.mechanism.dynamics import Dynamics
from tests.planter.mechanism.state_space.statements import CRANKS
from tests.support import own
from tests.support.cli import run

PARALLELOGRAM = CRANKS.replace("range(3)", "range(2)").replace("in (1, 2)", "in (1,)")
"""Two equal cranks: in the flat pose the coupler may also fold."""


@pytest.mark.parametrize("text", [CRANKS, PARALLELOGRAM], ids=["three cranks", "parallelogram"])
@pytest.mark.parametrize("tolerance", [1e-5, 1e-10])
def test_flat_pose_is_passed_on_the_same_branch(text: str, tolerance: float) -> None:
    """Cranks stay parallel, the coupler level, and the drive's work is the change of energy."""
    dynamics = Dynamics(own.file(text, "own"))
    motion = dynamics.run(np.linspace(0.0, 4.0, 201), tolerance)
    first, *further, coupler = motion.states[: dynamics.size]
    assert first.max() > 0.5 > -0.5 > first.min()
    assert np.abs(np.array(further) - first).max() < 1e-5
    assert np.abs(coupler).max() < 1e-5
    energy = motion.results["kinetic"] + motion.results["potential"]
    assert np.ptp(energy - 2 * first) < max(1e3 * tolerance, 1e-6)


@pytest.mark.parametrize("text", [CRANKS, PARALLELOGRAM], ids=["three cranks", "parallelogram"])
def test_start_in_the_flat_pose_is_refused(text: str) -> None:
    flat = text.replace("[0]: 1.0", "[0]: PLACE").replace("[i]: 1.0", "[i]: PLACE")
    with pytest.raises(errors.ComputationError, match=r"at 0 s the pose a0 = 0, .* gap_Q1x"):
        Dynamics(own.file(flat.replace("PLACE", "0"), "own")).run(np.array([0.0, 0.1]))
    motion = Dynamics(own.file(flat.replace("PLACE", "1e-4"), "own")).run(np.array([0.0, 0.3]))
    assert motion.states[1, -1] == pytest.approx(motion.states[0, -1], abs=1e-8)


def test_commands_tell_a_start_in_the_flat_pose() -> None:
    flat = CRANKS.replace("[0]: 1.0", "[0]: 0").replace("[i]: 1.0", "[i]: 0")
    file = own.generated(flat) / "own.toml"
    for command in ("move", "simulate"):
        code, _, message = run(command, str(file), "--until", "0.5")
        assert code == 1
        assert "singular" in message
