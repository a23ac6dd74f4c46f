"""The emitted formulas of the mapping: derived linkage, limits and curvature against geometry by
complex numbers.
"""

import random
from functools import cache

import mpmath as mp
import numpy as np
import pytest
import sympy as sp

from derive.model import ClosedForm
from derive.papers.mapping import model as formulas
from derive.papers.mapping import model as linkage
from derive.papers.mapping import quantities as q
from derive.quantity import Quantity
from tests.support.late import LateDict

exact = cache(formulas.build_mapping_system)
FORMS = LateDict(lambda: {form.name: form for form in exact().closed_forms})


def run(form: ClosedForm, inputs: dict[sp.Symbol, mp.mpf]) -> dict[str, mp.mpf]:
    """The outputs of a function by its own steps."""
    values = dict(inputs)
    for step in form.steps:
        values[step.symbol] = mp.mpf(sp.N(step.expr.xreplace(values), 30))
    return {out.name: values[out] for out in form.outputs}


def point(seed: int) -> dict[sp.Symbol, mp.mpf]:
    """Random values of all inputs."""
    rng = random.Random(seed)
    symbols = {
        s for form in exact().closed_forms for argument in form.inputs for s in _entries(argument)
    }
    return {s: mp.mpf(rng.uniform(0.3, 1.5)) for s in sorted(symbols, key=str)}


def _entries(argument: object) -> tuple[Quantity, ...]:
    return (argument,) if isinstance(argument, Quantity) else tuple(argument)


def placed(at: dict[sp.Symbol, mp.mpf]) -> tuple[complex, complex, complex, complex]:
    """Both moving hinges and both fixed ones by complex numbers."""
    turn = mp.expj(at[q.phi])
    fixed = mp.mpc(at[q.X_c], at[q.Y_c])
    hinge = fixed + at[q.L1] * mp.expj(at[q.theta])
    other = hinge + turn * mp.mpc(at[linkage.t.x_f] - at[q.x], at[linkage.t.y_f] - at[q.y])
    return hinge, other, fixed, mp.mpc(at[linkage.t.X_f], at[linkage.t.Y_f])


@pytest.mark.parametrize("seed", range(3))
def test_closure_is_the_gap_of_the_follower(seed: int) -> None:
    at = point(seed)
    _, other, _, pivot = placed(at)
    outputs = run(FORMS["closed"], at)
    assert outputs["closure"] == pytest.approx(
        float(abs(other - pivot) ** 2 - at[linkage.t.L_f] ** 2), rel=1e-12
    )
    loop = run(FORMS["loop"], at)
    by_loop = (
        loop["of_cos"] * mp.cos(at[q.phi]) + loop["of_sin"] * mp.sin(at[q.phi]) + loop["alone"]
    )
    assert float(by_loop) == pytest.approx(float(outputs["closure"]), rel=1e-12)


def test_transmission_angle_is_between_coupler_and_follower() -> None:
    at = point(5)
    hinge, other, _, pivot = placed(at)
    outputs = run(FORMS["transmission"], at)
    ratio = (other - pivot) * mp.conj(other - hinge)
    assert float(outputs["along"]) == pytest.approx(float(ratio.real))
    assert float(outputs["across"]) == pytest.approx(float(ratio.imag))


def test_arm_carries_tip_and_hinge() -> None:
    at = point(6)
    hinge = placed(at)[0]
    tip = hinge - mp.expj(at[q.phi]) * mp.mpc(at[q.x], at[q.y])
    outputs = run(FORMS["arm"], at)
    assert [float(outputs[n]) for n in ("d1", "d2", "X", "Y")] == pytest.approx(
        [float(v) for v in (tip.real, tip.imag, hinge.real, hinge.imag)]
    )


def train(slope: float) -> dict[sp.Symbol, mp.mpf]:
    return {q.slope: mp.mpf(-slope), q.x_s: mp.mpf("0.97"), q.a: mp.mpf("0.07")}


def test_curvature_of_circles() -> None:
    at = {
        **train(1.0),
        q.x_s: mp.mpf(1),
        formulas.t.dslope: mp.mpf(0),
        formulas.t.ddslope: mp.mpf(0),
    }
    assert [float(v) for v in run(FORMS["curvature"], at).values()] == pytest.approx([2 / 0.07] * 4)


def test_mate_curvature_matches_euler_savary() -> None:
    """Rolling curves: the difference of curvatures along the common normal is that of the pitch
    radii.

    With the angle psi between the tangent and the line of centres, (kappa1 + kappa2) = (1/r1 +
    1/r2) sin(psi).
    """
    at = {**train(0.7), formulas.t.dslope: mp.mpf("0.4"), formulas.t.ddslope: mp.mpf("-0.9")}
    kappa = run(FORMS["curvature"], at)
    step = mp.mpf("1e-8")
    for (r1, r2, rate), (k1, k2) in zip(
        (("r1", "r2", "dpsi1"), ("r3", "r4", "dpsi3")),
        (("kappa1", "kappa2"), ("kappa3", "kappa4")),
        strict=True,
    ):
        gears = run(FORMS["gears"], train(0.7))
        ahead, behind = (
            run(FORMS["gears"], {**train(0.7), q.slope: mp.mpf("-0.7") + s}) for s in (step, -step)
        )
        drift = (ahead[r1] - behind[r1]) / (2 * step) * mp.mpf("0.4")
        sine = gears[r1] * gears[rate] / mp.sqrt((gears[r1] * gears[rate]) ** 2 + drift**2)
        assert float(kappa[k1] + kappa[k2]) == pytest.approx(
            float((1 / gears[r1] + 1 / gears[r2]) * sine), rel=1e-7
        )
    assert float(kappa["kappa1"]) != pytest.approx(float(kappa["kappa2"]))


def test_either_reading_of_the_split_gives_the_same_gears() -> None:
    """i1 = x_s sqrt(i) and i1 = sqrt(x_s i) both close the first stage: the second with the square
    of the first.
    """
    i, mean = sp.symbols("i mean", positive=True)
    first, second = sp.symbols("first second", positive=True)
    (root,) = sp.solve(mean / first - 1, first)
    (other,) = sp.solve(mean / sp.sqrt(second) - 1, second)
    assert other == root**2
    assert sp.simplify(root * sp.sqrt(i) - sp.sqrt(other * i)) == 0


def test_bend_angle_matches_the_triangle() -> None:
    outputs = run(FORMS["bend"], {q.L1: mp.mpf("0.099724"), q.a: mp.mpf("0.07")})
    assert float(outputs["bend"]) == pytest.approx(2 * np.arcsin(0.099724 / 0.14))
