"""The clutch's linkage, engagement and slip against numeric mechanics and closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

from derive.papers.clutch import quantities as q
from tests.support.clutch import CLAIMS, number


def test_crank_gear_rolls_on_the_rack() -> None:
    """Equal arcs on both pitch circles; the link adds its own turn."""
    k, gamma, alpha = 0.3, np.deg2rad(85), np.deg2rad(25)
    arc = alpha - np.deg2rad(5)
    relative = number(
        "rotation of the crank gear relative to the link", k=k, gamma=gamma, alpha=alpha
    )
    assert relative * k == pytest.approx(arc, rel=1e-13)
    assert number(
        "rotation of the crank gear with the link", k=k, gamma=gamma, alpha=alpha
    ) == pytest.approx(relative + arc, rel=1e-13)
    assert (
        number("rotation of the crank gear with the link", k=k, gamma=gamma, alpha=np.deg2rad(4))
        == 0
    )


def test_crank_gear_revolution_counts_the_teeth() -> None:
    claim = "rotation of the crank gear for a number of teeth"
    assert number(claim, n=14.0, m=0.002, r_A=0.014) == pytest.approx(2 * np.pi, rel=1e-14)


def test_crank_against_closed_triangles() -> None:
    crank, rod, start, travel = 15.0, 44.8, 40.0, 5.7

    def angle(distance: float) -> float:
        return brentq(lambda s: abs(distance - crank * np.exp(1j * s)) - rod, 0, np.pi, xtol=1e-15)

    turned = number(
        "rotation of the crank for the travel of the sleeve",
        l_AB=crank,
        l_BC=rod,
        l_AC=start,
        c=travel,
    )
    assert turned == pytest.approx(angle(start) - angle(start + travel), rel=1e-12)


# engagement

SHAFT = {"E": 206e9, "I": 9.6e-9, "rho": 7850.0, "S": 3.46e-4, "l": 0.06}


def test_mode_equals_simply_supported_double_length() -> None:
    """Its frequency is (pi/L)^2 sqrt(EI/(rho S)), exactly."""
    E, I, rho, S, l = SHAFT.values()  # noqa: E741
    mass = number("modal mass of the shaft", rho=rho, S=S, l=l)
    stiffness = number("modal stiffness of the shaft", E=E, I=I, l=l)
    assert np.sqrt(stiffness / mass) == pytest.approx(
        (np.pi / (2 * l)) ** 2 * np.sqrt(E * I / (rho * S)), rel=1e-13
    )
    assert mass == pytest.approx(
        quad(lambda x: rho * S * np.sin(np.pi * x / (2 * l)) ** 2, 0, l)[0], rel=1e-12
    )


def test_contact_against_integration() -> None:
    """Newton's law for body and mode, integrated: deflection, load and largest load."""
    m1, F_M, speed, r1 = 0.35, 114.0, 4.71, 0.0105
    E, I, rho, S, l = SHAFT.values()  # noqa: E741
    mass, stiffness = rho * S * l / 2, np.pi**4 * E * I / (32 * l**3)
    times = np.linspace(0, 5e-4, 2001)
    solution = solve_ivp(
        lambda _, s: [s[1], (F_M - stiffness * s[0]) / (mass + m1)],
        (0, 5e-4),
        [0, speed * r1],
        t_eval=times,
        rtol=1e-11,
        atol=1e-16,
        method="DOP853",
    )
    load = F_M - m1 * (F_M - stiffness * solution.y[0]) / (mass + m1)
    values = {"m1": m1, "m2": rho * S * l}
    B1 = number("circular frequency in contact", E=E, I=I, l=l, **values)
    B2 = number("acceleration by the driving force", F_M=F_M, **values)
    start = {"B1": B1, "B2": B2, "Delta_omega": speed, "r1": r1}
    for i in range(0, 2001, 100):
        t = float(times[i])
        assert number("deflection at the contact over time", t=t, **start) == pytest.approx(
            solution.y[0, i], abs=1e-14, rel=1e-7
        )
        assert number("contact load over time", t=t, F_M=F_M, m1=m1, **start) == pytest.approx(
            load[i], rel=1e-6
        )
    largest = number(
        "largest contact load", E=E, I=I, l=l, F_M=F_M, Delta_omega=speed, r1=r1, **values
    )
    assert largest == pytest.approx(load.max(), rel=1e-5)
    assert largest > load.max() * (1 - 1e-9)


def test_section_of_a_hexagon() -> None:
    """Area and second moment by Simpson's integral of the width across it."""
    heights = np.linspace(-np.sqrt(3) / 2, np.sqrt(3) / 2, 200001)
    width = 2 - np.abs(heights) * 2 / np.sqrt(3)
    assert number("section of the shaft", a1=1.0) == pytest.approx(
        np.trapezoid(width, heights), rel=1e-9
    )
    assert number("second moment of the shaft", a1=1.0) == pytest.approx(
        np.trapezoid(width * heights**2, heights), rel=1e-9
    )


def test_slip_against_vectors() -> None:
    """Reactions, load and friction as vectors; the tooth moves along the surface only."""
    theta0, F_y, N, f0, m1 = 0.6, 4.0, 60.0, 5.0, 0.35
    direction = np.array([np.cos(theta0), -np.sin(theta0)])
    across = np.array([np.sin(theta0), np.cos(theta0)])
    a0 = number("acceleration of the slip", theta0=theta0, F_y=F_y, N=N, f0=f0, m1=m1)
    F_x = (N - F_y * across[1]) / across[0]
    force = np.array([F_x, F_y]) - N * across - f0 * direction
    assert force == pytest.approx(m1 * a0 * direction, abs=1e-12)
    values = {q.theta0: theta0, q.F_x: F_x, q.F_y: F_y, q.N: N, q.f0: f0, q.m1: m1, q.a0: a0}
    for claim in (
        "forces on the tooth across the surface",
        "forces on the tooth along the surface",
    ):
        assert float(CLAIMS[claim].residual.subs(values)) == pytest.approx(0, abs=1e-12)
    assert (float(CLAIMS["load at which the tooth slips"].residual.subs(values)) > 0) == (a0 > 0)
