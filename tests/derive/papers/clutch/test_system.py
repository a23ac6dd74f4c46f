"""What is emitted of the clutch: the derivation's and the paper's own equations."""

from __future__ import annotations

import importlib
import random
import re
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import mpmath
import numpy as np
import pytest
import sympy as sp

from derive.emit.text import list_functions
from derive.equations import ClaimError, Equation
from derive.model import ClosedForm, Let, System
from derive.papers import shi2021
from derive.papers.clutch import geometry
from derive.papers.clutch import model as clutch_model
from derive.papers.clutch import quantities as q
from derive.papers.clutch import subject as claims
from derive.quantity import Vector
from planter.kernels.formulas import load
from tests.support import xp_mpmath
from tests.support.late import LateDict
from tests.support.made_up import MadeUpClaim

MODELS = LateDict(
    lambda: {
        model.name: model
        for model in (
            clutch_model.build_clutch_system(),
            clutch_model.build_printed_clutch(
                shi2021.PAPER.equations, shi2021.COMPLETION, shi2021.LACKING
            ),
        )
    }
)
START: dict[str, Any] = {
    "a": 0.017,
    "theta": 1.3,
    "phi": 0.3,
    "mu": 0.15,
    "F1": 60.0,
    "F2": 40.0,
    "c": 0.0042,
    "R2": 0.013,
    "d": 0.01,
    "alpha": 0.5,
    "k": 0.35,
    "gamma": 1.45,
    "r_A": 0.014,
    "m": 0.002,
    "l_AB": 0.015,
    "l_BC": 0.0471,
    "l_AC": 0.04,
}
"""A value for every input of the printed forms."""


def form_of(name: str, form: str) -> ClosedForm:
    return next(s for s in MODELS[name].closed_forms if s.name == form)


def inputs(form: ClosedForm, values: dict[str, Any]) -> dict[str, Any]:
    return {
        g.name: [values[s.name] for s in g] if isinstance(g, Vector) else values[g.name]
        for g in form.inputs
    }


def array(name: str, form: str, xp: Any, arguments: dict[str, Any]) -> tuple[Any, ...]:
    return getattr(importlib.import_module(f"generated.array.{name}"), form)(xp, **arguments)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(
    "form", ["polygon", "path", "travel", "gears", "limit", "taper", "face", "angle"]
)
def test_exact_forms_are_the_derived_claims_to_forty_digits(form: str, seed: int) -> None:
    """The claims speak of several pentagons; here the sleeve's alone: its width is that of its
    side.
    """
    with mpmath.workdps(60):
        point = claims.SUBJECT.admissible(random.Random(seed))
        values = {s.name: v for s, v in point.items()} | {"flats": mpmath.sqrt(3) * point[q.a1]}
        if form == "angle":
            values["c"] = point[q.c_min]
        arguments = inputs(form_of("clutch_exact", form), values)
        results = array("clutch_exact", form, SimpleNamespace(**vars(xp_mpmath)), arguments)
        for symbol, value in zip(form_of("clutch_exact", form).outputs, results, strict=True):
            assert abs(value - point[symbol]) <= mpmath.mpf(10) ** -40 * max(
                abs(point[symbol]), 1
            ), symbol


@pytest.mark.parametrize("form", ["polygon", "path", "travel", "taper", "gears", "limit"])
def test_printed_forms_satisfy_only_printed_equations(form: str) -> None:
    results = START | load("clutch_printed").at(
        form, **inputs(form_of("clutch_printed", form), START)
    )
    sources = {step.source for step in form_of("clutch_printed", form).steps}
    equations = [
        e
        for e in shi2021.PAPER.equations.values()
        if e.source in sources and e.legibility == "printed"
    ]
    assert len(equations) == len(sources - {"shi2021 (a)"})
    for equation in equations:
        symbols = sorted(equation.residual.free_symbols, key=str)
        residual = sp.lambdify(symbols, equation.residual, "numpy")(
            *(results[s.name] for s in symbols)
        )
        assert abs(residual) < 1e-14, equation.number


def test_a_misprint_changes_the_printed_model_alone() -> None:
    equations = dict(shi2021.PAPER.equations)
    printed = equations["4b"]
    once = q.c_min - (q.b - sp.sqrt(3) * q.a / 2) / sp.tan(q.phi)
    equations["4b"] = Equation("4b", once, printed.source, printed.claims, defines=q.c_min)
    mended = clutch_model.build_printed_clutch(equations, shi2021.COMPLETION, shi2021.LACKING)
    before, after = (
        next(s for s in m.closed_forms if s.name == "travel")
        for m in (MODELS["clutch_printed"], mended)
    )
    ratio = before.steps[1].expr / after.steps[1].expr
    assert sp.simplify(ratio) == 2
    assert form_of("clutch_exact", "travel") == next(
        s for s in clutch_model.build_clutch_system().closed_forms if s.name == "travel"
    )


def test_missing_equation_gives_no_output() -> None:
    equations = {n: e for n, e in shi2021.PAPER.equations.items() if n != "2b"}
    lacking = shi2021.LACKING | {"path of C, y"}
    printed = clutch_model.build_printed_clutch(equations, shi2021.COMPLETION, lacking)
    path = next(s for s in printed.closed_forms if s.name == "path")
    assert [s.name for s in path.outputs] == ["R", "A1", "A2", "beta", "x_C", "x_A", "e_3"]


def test_undeclared_missing_equation_is_refused() -> None:
    equations = {n: e for n, e in shi2021.PAPER.equations.items() if n != "2b"}
    with pytest.raises(
        ClaimError,
        match=r"nothing here states 'path of C, y'; near it: .*'path of C, x'",
    ):
        clutch_model.build_printed_clutch(equations, shi2021.COMPLETION, shi2021.LACKING)
    for claim in shi2021.LACKING:
        with pytest.raises(ClaimError, match=re.escape(f"nothing here states '{claim}'")):
            clutch_model.build_printed_clutch(
                shi2021.PAPER.equations, shi2021.COMPLETION, shi2021.LACKING - {claim}
            )


def test_present_equation_declared_missing_is_refused() -> None:
    with pytest.raises(ClaimError, match="said to be lacking, but stated: 'path of C, y'"):
        clutch_model.build_printed_clutch(
            shi2021.PAPER.equations, shi2021.COMPLETION, shi2021.LACKING | {"path of C, y"}
        )


@pytest.mark.parametrize(
    ("claim", "sentence"),
    [
        (MadeUpClaim.NOWHERE, "nothing here states 'made-up sum that nothing derives'"),
        ("path of C, x", r"shi2021 \(2a\) and shi2021 \(2b\) claim the same: path of C, x"),
        ("focus of the ellipse, x", "said to be lacking, but stated: 'focus of the ellipse, x'"),
    ],
)
def test_a_wrong_claim_of_the_paper_is_refused(claim: str, sentence: str) -> None:
    equations = {
        **shi2021.PAPER.equations,
        "2b": replace(shi2021.PAPER.equations["2b"], claims=claim),
    }
    with pytest.raises(ClaimError, match=sentence):
        clutch_model.build_printed_clutch(equations, shi2021.COMPLETION, shi2021.LACKING)


def test_undecidable_inequality_is_refused() -> None:
    equations = {n: e for n, e in shi2021.PAPER.equations.items() if n != "4b"}
    with pytest.raises(ValueError, match="margin_travel needs c_min, which nothing gives"):
        clutch_model.build_printed_clutch(
            equations, shi2021.COMPLETION, shi2021.LACKING | {"least travel of the sleeve"}
        )


def test_functions_contain_only_needed_steps() -> None:
    spare = Let(q.f, q.a * 3, "spare")
    form = ClosedForm("one", (q.a,), (spare, Let(q.b, 2 * q.a, "kept")), Vector("one", (q.b,)))
    (emitted,) = list_functions(System("x", "x", "x", (), closed_forms=(form,)))
    assert [s.source for s in emitted.steps] == ["kept"]


def test_the_largest_overlap_is_the_largest_of_the_claim() -> None:
    claim = claims.derive_formulas().equations["overlap with the third pair of sides"]
    overlap = sp.lambdify(q.theta, (q.e_3 - claim.residual).subs(q.R, 1), "numpy")
    sampled = np.abs(
        [float(overlap(t)) for t in np.linspace(11 * np.pi / 30, np.pi / 2, 2001)]
    ).max()
    assert load("clutch_exact").at("rotor", a=1 / np.sqrt(3))["miss"] == pytest.approx(
        sampled, rel=1e-6
    )
    assert load("clutch_exact").at("rotor", a=1 / np.sqrt(3))["miss"] >= sampled - 1e-15


def test_the_fillet_of_the_general_rotor_is_the_claim() -> None:
    """Two derivations: where the fillet begins, and the reach of path and fillet in every
    direction.
    """
    angles = geometry.substitute_angles(geometry.least_fillet())
    shape = [1.0, 0.5, 5.0, 6.0]
    assert load("clutch_rotor").at("ellipse", shape=shape)["fillet"] == pytest.approx(
        float(angles), rel=1e-13
    )
