"""The emitted pick-up against its own derivation at sixty digits, over the built-in cycle, and its
special places.
"""

import random
from collections.abc import Mapping

import mpmath as mp
import numpy as np
import pytest
import sympy as sp

from derive.equations import Claimed, ClaimError
from derive.evaluate import MachineFile
from derive.mechanics.gearing import teeth
from derive.papers.pickup import model
from derive.papers.pickup import quantities as q
from derive.papers.pickup import subject as claims
from derive.papers.pickup import subject as points
from derive.quantity import Quantity
from planter.kernels.formulas import load
from tests.support.late import LateList

MODEL = load("pickup_exact")
TEETH = load("gear_teeth")
CYCLE = LateList(lambda: claims.SUBJECT.reference(24))
POINTS = LateList(lambda: [claims.SUBJECT.admissible(random.Random(seed)) for seed in range(12)])
IN_CYCLE, AT_RANDOM = (
    [(points, k) for k in range(count)] for points, count in ((CYCLE, 20), (POINTS, 12))
)
Point = Mapping[Quantity, mp.mpf]


@pytest.fixture
def point(request: pytest.FixtureRequest) -> Point:
    points, k = request.param
    return points[k]


def numbers(point: Point, *symbols: Quantity) -> np.ndarray:
    return np.array([float(point[s]) for s in symbols])


def agrees(values: Mapping[str, float], point: Point, *symbols: Quantity) -> None:
    for symbol in symbols:
        assert values[str(symbol)] == pytest.approx(float(point[symbol]), rel=1e-11, abs=1e-13), (
            symbol
        )


@pytest.mark.parametrize("point", [*IN_CYCLE[::5], *AT_RANDOM], indirect=True)
def test_places_and_velocities(point: Point) -> None:
    triangle = numbers(point, q.L1, q.L2, q.gamma, q.a1, q.a2, q.beta1)
    slope = float(1 / point[q.iZ])
    phi5, phi1, omega = numbers(point, q.phi5, q.phi1, q.omega)
    outputs = MODEL.at("motion", phi5=phi5, phi1=phi1, g=slope, omega=omega, triangle=triangle)
    agrees(outputs, point, q.x_M1, q.y_M1, q.x_O1, q.y_O1, q.x_S, q.y_S, q.vx_S, q.vy_S, q.L3)


@pytest.mark.parametrize("point", IN_CYCLE, indirect=True)
def test_law_pitch_curves_and_contact(point: Point) -> None:
    t = float(point[q.phi5] - point[q.phi50])
    machine = MachineFile.read(points.MACHINE)
    dwell = [float(angle) for angle in machine.all_si("law.dwell_t_deg")]
    law = MODEL.at("law", t=t, law=np.array([float(machine.si("law.p")), *dwell, np.pi]))
    assert law["phi1"] == pytest.approx(float(point[q.phi1]), abs=1e-13)
    assert law["g"] == pytest.approx(float(1 / point[q.iZ]), abs=1e-13)
    slopes = np.array([law[name] for name in ("g", "dg", "ddg")])
    angles = {"phi5": float(point[q.phi5]), "phi2": float(point[q.phi2])}
    outputs = MODEL.at("pitch", slopes=slopes, a1=float(point[q.a1]), **angles)
    agrees(outputs, point, q.R1, q.R2, q.dR1, q.ddR1, q.x1, q.y1, q.x2, q.y2)
    assert 1 / outputs["kappa1"] == pytest.approx(float(point[q.rho1]))
    assert 1 / outputs["kappa2"] == pytest.approx(float(point[q.rho2]))
    bends = {name: outputs[name] for name in ("kappa1", "kappa2")}
    agrees(
        TEETH.at("contact_ratio", **bends, teeth=numbers(point, q.m, q.ha1, q.ha2, q.alpha0)),
        point,
        q.epsilon,
    )


@pytest.mark.parametrize("point", [IN_CYCLE[0], *AT_RANDOM], indirect=True)
def test_helical_pair_and_triangle(point: Point) -> None:
    arguments = numbers(point, q.L1, q.gamma, q.a2, q.m_n, q.z_1, q.z_2, q.B, q.alpha_n, q.ha_n)
    agrees(
        MODEL.at("carrier", carrier=arguments),
        point,
        q.beta,
        q.alpha_t,
        q.epsilon_h,
        q.beta1,
        q.U1,
        q.a1,
    )


@pytest.mark.parametrize(
    "phi1", [*np.linspace(np.pi, 3 * np.pi, 41), np.pi + 1e-9, 2 * np.pi - 1e-9, 2 * np.pi + 1e-9]
)
def test_triangle_inverse_is_accurate(phi1: float) -> None:
    """Arm and carrier from the tip, by squares less those of the extremes, formed at fifty
    digits.
    """
    with mp.workdps(50):
        bar_1, bar_2, phi5 = mp.mpf("0.09"), mp.mpf("0.16"), mp.mpf("0.4")
        tip = bar_1 * mp.expj(phi5) + bar_2 * mp.expj(phi5 + mp.pi - mp.mpf(phi1))
        short, over = (bar_1 + bar_2) ** 2 - abs(tip) ** 2, abs(tip) ** 2 - (bar_2 - bar_1) ** 2
        squares = {"short": float(abs(short)), "over": float(abs(over))}
        way = 1.0 if phi1 < 2 * np.pi else -1.0
    bars = np.array([0.09, 0.16])
    outputs = MODEL.at(
        "inverse", x_S=float(tip.real), y_S=float(tip.imag), way=way, bars=bars, **squares
    )
    assert outputs["phi1"] == pytest.approx(phi1, abs=1e-15)
    assert np.exp(1j * (outputs["phi5"] - 0.4)) == pytest.approx(1, abs=1e-14)
    by_cosine = np.arccos((0.09**2 + 0.16**2 - abs(complex(tip)) ** 2) / (2 * 0.09 * 0.16))
    if 1e-10 < abs(phi1 - 2 * np.pi) < 1e-8:
        assert abs(by_cosine - abs(phi1 - 2 * np.pi)) > 1e-10


def test_bars_follow_from_the_extremes() -> None:
    assert MODEL.at("bars", L3_max=0.25, L3_min=0.07) == pytest.approx({"L1": 0.09, "L2": 0.16})


def test_place_in_the_cell_is_a_rotation() -> None:
    arguments = {"x_S": 0.3, "y_S": -0.2, "x_bottom": 0.1, "y_bottom": 0.05}
    outputs = MODEL.at("entry", axis=0.7, **arguments)
    assert complex(outputs["along"], outputs["across"]) == pytest.approx(
        complex(0.2, -0.25) * np.exp(-0.7j)
    )


def test_the_wrong_root_of_the_path_of_action_is_not_taken() -> None:
    _, path = teeth.path_by_curvature(model.s.kappa1, sp.Symbol("h"), sp.Symbol("alpha"))
    assert path.subs({model.s.kappa1: 10, "h": 0.002, "alpha": 0.35}).evalf() > 0


@pytest.mark.parametrize("claim", ["place of M2, x", "row of a knot", "place of {}, {}"])
def test_step_without_derivation_is_refused(claim: Claimed) -> None:
    with pytest.raises(ClaimError, match="nothing here states"):
        claims.derive_formulas().steps("bar L1 from the extremes", claim)
    assert [step.symbol for step in claims.derive_formulas().steps("bar L1 from the extremes")] == [
        q.L1
    ]
