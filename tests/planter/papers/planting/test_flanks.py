"""Laws of the cam's flanks: a machine file chooses one, and where it is not smooth follows from the
law itself.
"""

import numpy as np
import pytest

from planter.kernels import Kernel
from planter.papers.planting import functions, objective
from planter.papers.planting.model import Device
from tests.support import kinematics, machines
from tests.support.jets import Jet

EIGHTHS = (0.0, 0.125, 0.375, 0.625, 0.875, 1.0)
ORDERS = {
    "4-5-6-7 polynomial": {0.0: 2, 1.0: 2},
    "3-4-5 polynomial": {0.0: 1, 1.0: 1},
    "cycloidal": {0.0: 1, 1.0: 1},
    "harmonic": {0.0: 0, 1.0: 0},
    "modified sine": {0.0: 1, 0.125: 2, 0.875: 2, 1.0: 1},
    "modified trapezoid": {0.0: 1, 0.125: 2, 0.375: 2, 0.625: 2, 0.875: 2, 1.0: 1},
}


def device(law: str) -> Device:
    return Device(machines.with_flank(machines.machine("compact"), law))


def test_every_law_of_the_textbook_is_there() -> None:
    assert set(functions.list_flank_laws()) == kinematics.FLANKS.keys() == ORDERS.keys()


@pytest.mark.parametrize("law", ORDERS)
def test_flank_law_equals_textbook_with_slopes(law: str) -> None:
    x = np.linspace(0.001, 0.999, 333)
    values = Kernel(functions.build_flank_function(law), lanes=["x"])(x=x)
    book = kinematics.flank(law, Jet(np, x, np.ones_like(x), np.zeros_like(x)))
    for name, part in zip(("p", "dp", "ddp"), book.parts, strict=True):
        assert values[name][0] == pytest.approx(part, abs=1e-11)


@pytest.mark.parametrize("law", ORDERS)
def test_joints_of_a_law_are_where_a_derivative_jumps(law: str) -> None:
    breakpoints = {
        joint.position: joint.order for joint in functions.find_flank_breakpoints(law, EIGHTHS)
    }
    assert breakpoints == ORDERS[law]


@pytest.mark.long
@pytest.mark.parametrize("law", ["modified sine", "harmonic"])
def test_true_extremes_are_those_of_a_dense_cycle(law: str) -> None:
    subject = device(law)
    joints = subject.force
    assert {event.name for event in joints.events if event.name.startswith("cam")} >= {
        "cam, start of the rise"
    }
    phi = np.linspace(0, np.pi, 400_001)
    force = subject.support(subject.prologue(subject.design), phi)
    extremes = objective.evaluate_true_extremes(subject, subject.design)
    assert extremes.max_N == pytest.approx(force.max(), abs=1e-4)
    assert extremes.min_N == pytest.approx(force.min(), abs=1e-4)
    assert extremes.variance_N2 == pytest.approx(force[:-1].var(), rel=1e-4)


def test_gradient_under_a_jumping_law_agrees_with_differences() -> None:
    machine = device("harmonic")
    goal, step = objective.build_problem(machine).goal, 1e-6 * (machine.upper - machine.lower)
    ends = [
        (goal.evaluate(machine.design + s), goal.evaluate(machine.design - s))
        for s in np.diag(step)
    ]
    slopes = [(above - below) for above, below in ends]
    assert 2 * goal.slope(machine.design) * step == pytest.approx(slopes, rel=1e-3, abs=1e-9)
