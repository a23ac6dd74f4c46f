"""The one-mode engagement: shapes of bending, modal mass and stiffness, the swing of the load."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import quad, solve_ivp
from scipy.linalg import eigh

from derive.equations import ClaimError
from derive.formulas import Formulas
from derive.papers import shi2021
from derive.papers.clutch import model as beam
from derive.papers.clutch import motion as clutch_motion
from derive.papers.clutch import quantities as q
from tests.support.late import LateDict

SHAPES = beam.bending_shapes()
COEFFICIENTS = LateDict(
    lambda: {name: beam.shape_integrals(shape) for name, shape in SHAPES.items()}
)


@pytest.mark.parametrize("name", SHAPES)
def test_shapes_are_zero_at_bearing_and_unity_at_contact(name: str) -> None:
    shape = SHAPES[name]
    assert abs(sp.N(shape.subs(beam.Z, 0), 30)) < 1e-25
    assert abs(sp.N(shape.subs(beam.Z, 1) - 1, 30)) < 1e-25
    slope = abs(sp.N(shape.diff(beam.Z).subs(beam.Z, 0)))
    assert slope < 1e-20 if name.startswith("clamped") else slope > 1


@pytest.mark.parametrize("name", SHAPES)
def test_coefficients_are_the_integrals_of_the_shape(name: str) -> None:
    exact = [float(c) for c in COEFFICIENTS[name]]
    for expr, coefficient in zip((SHAPES[name], SHAPES[name].diff(beam.Z, 2)), exact, strict=True):
        curve = sp.lambdify(beam.Z, expr**2, "numpy")
        assert coefficient == pytest.approx(quad(curve, 0, 1, epsabs=1e-13)[0], rel=1e-11)


def test_textbook_coefficients() -> None:
    assert COEFFICIENTS["quarter_sine"] == (sp.Rational(1, 2), sp.pi**4 / 32)
    assert COEFFICIENTS["clamped_static"] == (sp.Rational(33, 140), sp.Integer(3))
    mass, stiffness = COEFFICIENTS["clamped_mode"]
    assert float(mass) == pytest.approx(0.25, abs=1e-18)
    assert float(stiffness / mass) == pytest.approx(1.8751040687119611**4, rel=1e-15)


def test_no_clamped_shape_swings_slower_than_the_eigenshape() -> None:
    """Rayleigh: the quotient of any admissible shape bounds the first frequency from above."""
    squares = {
        name: float(np.divide(*map(float, reversed(pair)))) for name, pair in COEFFICIENTS.items()
    }
    lowest = squares.pop("clamped_mode")
    assert lowest == pytest.approx(_finite_elements(), rel=1e-6)
    assert all(square > lowest for name, square in squares.items() if name.startswith("clamped"))
    assert squares["quarter_sine"] < lowest  # it turns freely at the bearing: not admissible there


def _finite_elements(count: int = 20) -> float:
    """Square of the first frequency of a clamped beam with E I = rho S = l = 1, by Hermite
    elements.
    """
    h = 1 / count
    k = (
        np.array(
            [
                [12, 6 * h, -12, 6 * h],
                [6 * h, 4 * h**2, -6 * h, 2 * h**2],
                [-12, -6 * h, 12, -6 * h],
                [6 * h, 2 * h**2, -6 * h, 4 * h**2],
            ]
        )
        / h**3
    )
    m = (
        np.array(
            [
                [156, 22 * h, 54, -13 * h],
                [22 * h, 4 * h**2, 13 * h, -3 * h**2],
                [54, 13 * h, 156, -22 * h],
                [-13 * h, -3 * h**2, -22 * h, 4 * h**2],
            ]
        )
        * h
        / 420
    )
    assembled = np.zeros((2, 2 * count + 2, 2 * count + 2))
    for i in range(count):
        part = slice(2 * i, 2 * i + 4)
        assembled[0, part, part] += k
        assembled[1, part, part] += m
    return float(eigh(assembled[0, 2:, 2:], assembled[1, 2:, 2:], eigvals_only=True)[0])


def test_the_papers_shape_gives_the_modal_mass_of_the_clutch() -> None:
    mass, stiffness = clutch_motion.modal_coefficients()
    coefficients = COEFFICIENTS["quarter_sine"]
    assert sp.simplify(mass - coefficients[0] * q.rho * q.S * q.l) == 0
    assert sp.simplify(stiffness - coefficients[1] * q.E * q.I / q.l**3) == 0


VALUES = {q.M_1: 0.08, q.K_1: 2.8e7, q.m1: 0.35, q.F_M: 114.0, q.Delta_omega: 4.7, q.r1: 0.0105}


def _extremes() -> dict[str, float]:
    stage = beam._add_extremes(
        Formulas("test"), (q.M_1, q.K_1, beam.STRUCK), *beam.frequency_steps()
    )
    substitutions: dict[sp.Symbol, object] = dict(VALUES)
    for step in stage.steps:
        substitutions[step.symbol] = float(step.expr.subs(substitutions))
    return {str(symbol): float(str(value)) for symbol, value in substitutions.items()}


def test_extremes_are_those_of_the_integrated_motion() -> None:
    """(8) in the one mode, integrated: largest load, its time, and the first time without any."""
    v = {str(s): value for s, value in VALUES.items()}
    moving, speed = v["M_1"] + v["m1"], v["Delta_omega"] * v["r1"]

    def motion(t: float, y: np.ndarray) -> list[float]:
        return [y[1], (v["F_M"] - v["K_1"] * y[0]) / moving]

    def load(t: float, y: np.ndarray) -> float:
        return v["F_M"] - v["m1"] * motion(t, y)[1]

    def rising(t: float, y: np.ndarray) -> float:
        return y[1]

    rising.direction = -1  # type: ignore[attr-defined]
    load.direction = -1  # type: ignore[attr-defined]
    ran = solve_ivp(
        motion,
        (0, 1e-3),
        [0, speed],
        events=[rising, load],
        rtol=1e-12,
        atol=1e-15,
        method="DOP853",
    )
    extremes = _extremes()
    assert extremes["N_0"] == pytest.approx(load(0, np.array([0, speed])), rel=1e-12)
    assert extremes["t_max"] == pytest.approx(ran.t_events[0][0], rel=1e-8)
    assert extremes["N_max"] == pytest.approx(load(0, ran.y_events[0][0]), rel=1e-8)
    assert extremes["t_loss"] == pytest.approx(ran.t_events[1][0], rel=1e-8)


def test_paper_uses_overhang_mass_not_modal_mass() -> None:
    (form,) = beam.build_printed_beam(shi2021.PAPER.equations).closed_forms
    rates = {str(step.symbol): step.expr for step in form.steps[:2]}
    assert sp.simplify(rates["B1"] ** 2 - sp.pi**4 / 32 * q.E * q.I / (q.m2 * q.l**3)) == 0
    assert sp.simplify(rates["B2"] - q.F_M / q.m2) == 0
    derived = {str(step.symbol): step.expr for step in beam.frequency_steps()}
    assert sp.simplify(derived["B2"] - rates["B2"].subs(q.m2, q.M_1 + q.m1)) == 0


@pytest.mark.parametrize("number", ["B1", "B2"])
def test_paper_without_initial_conditions_is_refused(number: str) -> None:
    equations = {n: e for n, e in shi2021.PAPER.equations.items() if n != number}
    with pytest.raises(
        ClaimError,
        match=f"nothing here states '{shi2021.PAPER.equations[number].claims}'",
    ):
        beam.build_printed_beam(equations)
