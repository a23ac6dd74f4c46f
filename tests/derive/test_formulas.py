"""Formulas: what is stated is found by its claim, solved, followed to values; the example against
its own geometry.
"""

import json
from pathlib import Path

import mpmath
import numpy as np
import pytest
import scipy.integrate

from derive.__main__ import main as derive
from derive.chain import ChainError
from derive.equations import ClaimError, what
from derive.formulas import Formulas
from derive.quantity import quantities
from tests.support import own

q = quantities("""
    r | m  | radius        | 2 | 1 3
    d | m  | diameter
    A | m2 | area
    p | m  | perimeter
""")


NOT_LESS = "the perimeter is not less than"


def disc() -> Formulas:
    f = Formulas("disc", given=q)
    f.defines(q.A, q.d**2 * 3 / 4)
    f.defines(q.d, 2 * q.r)
    f.holds(NOT_LESS, q.p - 3 * q.d, ">=")
    return f


def test_function_solves_in_the_requested_order() -> None:
    form = disc().function("sizes", (q.r,), what(q.d), what(q.A), (NOT_LESS, q.p), gives=(q.p, q.A))
    assert [(step.symbol, step.expr) for step in form.steps] == [
        (q.d, 2 * q.r),
        (q.A, 3 * q.d**2 / 4),
        (q.p, 3 * q.d),
    ]
    assert form.steps[0].source == "derived: what d is"
    assert (form.outputs.name, form.outputs.quantities) == ("sizes_outputs", (q.p, q.A))


def test_values_follow_from_definitions_in_any_order() -> None:
    assert disc().followed({q.r: mpmath.mpf(2)}) == {q.r: 2, q.d: 4, q.A: 12}
    assert disc().followed({q.r: mpmath.mpf(2)}, (NOT_LESS, q.p))[q.p] == 12
    assert disc().followed({q.p: mpmath.mpf(2)}) == {q.p: 2}


def test_unusable_claims_are_refused() -> None:
    for claim in (what("z"), NOT_LESS):
        with pytest.raises(ClaimError, match="nothing here states"):
            disc().steps(claim)
    with pytest.raises(ChainError, match="not linear in d"):
        disc().steps((what(q.A), q.d))
    with pytest.raises(ClaimError, match="claim the same: what d is"):
        disc().defines(q.d, 3 * q.r)
    with pytest.raises(ValueError, match="bad: d needs r, which nothing gives"):
        disc().function("bad", (q.A,), what(q.d))


def test_lacking_claims_remove_dependent_steps() -> None:
    stated = [e for e in disc().equations.values() if e.defines != q.d]
    with pytest.raises(
        ClaimError, match="said to be lacking, but stated: 'the perimeter is not less than'"
    ):
        Formulas("all", stated, lacking=frozenset({NOT_LESS}))
    without = Formulas("less", [e for e in stated if e.defines], lacking=frozenset({NOT_LESS}))
    assert without.steps((NOT_LESS, q.d), what(q.A)) == ()


def test_the_ellipses_of_the_example_roll() -> None:
    """Pitch radius from the sum of the focal distances; the mate's turn by quadrature of the
    ratio.
    """
    code = own.array_code("elliptic_gears")
    A, k = 0.021, 0.3

    def rolling(t: float) -> np.ndarray:
        return np.array(code.rolling(np, A=A, k=k, t=t), float)

    r, _, turned = rolling(1.1)
    end = r * np.exp(1.1j)
    assert abs(end) + abs(end - 2 * k * A) == pytest.approx(2 * A, rel=1e-14)
    integral, _ = scipy.integrate.quad(lambda t: rolling(t)[1], 0, 1.1, epsabs=1e-13)
    assert turned == pytest.approx(integral, rel=1e-12)


def test_example_paper_is_judged_by_the_formulas(tmp_path: Path) -> None:
    assert derive([str(own.EXAMPLES / "elliptic_gears.py"), "--out", str(tmp_path)]) == 0
    judged = {
        e["equation"]: e for e in json.loads((tmp_path / "audit.json").read_text())["equations"]
    }
    assert {n: e["verdict"] for n, e in judged.items()} == {
        "1": "confirmed",
        "2": "misprint",
        "3": "confirmed",
    }
    assert "sign of r" in judged["2"]["correction"]


def test_values_without_section_are_not_displayed() -> None:
    text = "a | mm | length | 3\n b | 1 | share"
    assert [s.shown for s in quantities(text).values()] == ["values.a_mm", "values.b"]
    assert [(s.shown, s.source) for s in quantities(text, "a paper", section="").values()] == [
        ("", "a paper")
    ] * 2
