"""The bridge to IPOPT, on a programme with a known answer."""

import numpy as np
import pytest

from planter.engine.solvers import ipopt


class Circle:
    """(x - 1)^2 + y^4 on x^2 + y^2 <= 1/2: x = sqrt 1/2, y = 0, multiplier sqrt 2 - 1."""

    lower, upper = np.array([-2.0, -2.0]), np.array([2.0, 2.0])
    g_lower, g_upper = np.array([-np.inf]), np.array([0.5])

    def f(self, z):
        return float((z[0] - 1) ** 2 + z[1] ** 4)

    def gradient(self, z):
        return np.array([2 * (z[0] - 1), 4 * z[1] ** 3])

    def g(self, z):
        return np.array([z @ z])

    def jacobian(self, z):
        return 2 * z[None, :]

    def hessian(self, z, weight, multipliers):
        return np.diag([2 * weight, 12 * weight * z[1] ** 2]) + 2 * multipliers[0] * np.eye(2)


def test_known_optimum_and_multiplier(capfd):
    solution = ipopt.solve_program(Circle(), np.array([0.3, 0.4]))
    assert solution.converged
    assert solution.z == pytest.approx([np.sqrt(0.5), 0], abs=1e-6)
    assert solution.multipliers == pytest.approx([np.sqrt(2) - 1], abs=1e-6)
    assert capfd.readouterr() == ("", "")


def test_callback_stops_the_search():
    solution = ipopt.solve_program(Circle(), np.array([0.3, 0.4]), most_iterations=3)
    assert not solution.converged
    assert solution.iterations == 3


@pytest.mark.parametrize("name", ["f", "gradient", "g", "jacobian", "hessian"])
@pytest.mark.parametrize("error", [KeyboardInterrupt, ValueError])
def test_errors_of_functions_are_raised(name, error, monkeypatch):
    def broken(*_):
        raise error("from inside")

    programme = Circle()
    monkeypatch.setattr(programme, name, broken)
    with pytest.raises(error, match="from inside"):
        ipopt.solve_program(programme, np.array([0.3, 0.4]))
