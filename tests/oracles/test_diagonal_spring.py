"""A four-bar with a diagonal spring (IFToMM library of computational benchmarks): its state of
rest, its eigenvalues.

Three unit bars of 1 kg on a unit base; the spring, unloaded at the length of the square's diagonal,
goes from one foot to the far corner. The angle of rest and the eigenvalues are the benchmark's, to
ten to twelve digits, as B. Minaker (University of Windsor, software EoM, solution 120 of that
library) cites them. The balance of moments about a foot, solved here to thirty digits, says that
the last two of the angle are off.
"""

import mpmath
import numpy as np
import pytest

from planter.mechanism.motion import eigenvalues, equilibrium
from tests.support import own

FOUR_BAR = '''
from sympy import Rational, sqrt

from derive import Mechanism, quantities

q = quantities("""
    g | m/s2  | free fall        | 9.81
    l | m     | bars and base    | 1
    m | kg    | each bar         | 1
    k | N/m   | diagonal spring  | 25
    c | N s/m | its damping      | 1
""")
m = Mechanism("four_bar", q, gravity=q.g)
names = ("left", "top", "right")
angles = [m.coordinate(name, "rad", f"{name} bar") for name in names]
frames = [m.frame(name, angle) for name, angle in zip(names, angles)]
foot = m.point("foot", m.O, m.world, q.l)
A, B = m.point("A", m.O, frames[0], q.l), m.point("B", foot, frames[2], q.l)
for name, frame, base in zip(names, frames, (m.O, A, foot)):
    body = m.body(name, frame, q.m, m.point(f"C {name}", base, frame, q.l / 2), q.m * q.l**2 / 12)
m.close(m.point("corner", A, frames[1], q.l), B, start={angles[0]: Rational(11, 5), angles[2]: Rational(11, 5)})
m.spring("diagonal", body, m.ground, (B, m.O), q.k, sqrt(2) * q.l, q.c)
SYSTEM = m.system(reported=["kinetic"])
'''
REST = 2.23433101898
FREE, DAMPED = 2.14767663837j, -0.2423858093 + 2.1339550282j


def angle_of_rest() -> float:
    """Of the rhombus: 2 m g l cos(phi) is the moment of the weights, the rest that of the
    spring.
    """
    with mpmath.workdps(30):
        weight, root = 2 * mpmath.mpf("9.81"), mpmath.sqrt(2)
        return float(
            mpmath.findroot(
                lambda x: (
                    weight * mpmath.cos(x) - 25 * (2 * mpmath.cos(x / 2) - root) * mpmath.sin(x / 2)
                ),
                2.2,
            )
        )


@pytest.mark.parametrize(
    ("damping", "printed", "digits"), [(0.0, FREE, 1e-11), (1.0, DAMPED, 5e-11)]
)
def test_rest_and_eigenvalues_are_those_of_the_benchmark(
    damping: float, printed: complex, digits: float
) -> None:
    """The eigenvalues in print are those at the angle in print."""
    four_bar = own.dynamics(FOUR_BAR, "four_bar", c_N_s_m=damping)
    left, top, right = (four_bar.names.index(name) for name in ("left", "top", "right"))
    at = equilibrium(four_bar)
    assert own.deviation("angle of rest", at[[left, right]], REST) < 1e-10
    assert own.deviation("its balance", at[[left, right]], angle_of_rest()) < 1e-14
    zero_rates = np.zeros_like(at)
    zero_rates[[left, top, right]] = REST, 0, REST
    first, second = eigenvalues(four_bar, zero_rates)
    assert own.deviation("eigenvalue", first, printed) < digits
    assert second == pytest.approx(first.conjugate(), rel=1e-12)


def test_stiffness_error_of_a_millionth_is_detected() -> None:
    four_bar = own.dynamics(FOUR_BAR, "four_bar", c_N_s_m=0.0, k_N_m=25.000025)
    roots = eigenvalues(four_bar, equilibrium(four_bar))
    assert np.abs(roots[0] - FREE) > 1e-8
