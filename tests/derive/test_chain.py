"""Chains: order by matching, linear steps, replacement, and what the printed model depends on."""

from pathlib import Path

import pytest
import sympy as sp
from sympy import Piecewise

from derive.chain import (
    BlockError,
    Chain,
    ChainError,
    Solve,
    Together,
    close_cases,
    ordered,
    solve_linear,
    solve_set,
)
from derive.equations import ClaimError, Definition, Equation, by_claim, defining_equation
from derive.model import Let, LinearSolve, System
from derive.papers import wang2017
from derive.papers.planting import derivation
from derive.papers.planting import quantities as q
from derive.quantity import Quantity
from tests.support.made_up import MadeUpClaim

a, b, c, k = (Quantity(name, "1", "test", "test") for name in "abck")


def equation(number: str, residual: sp.Expr, defines: Quantity | None = None) -> Equation:
    return Equation(number, residual, "test", Definition("test"), defines=defines)


def test_matching_determines_the_order() -> None:
    chain = ordered(
        [equation("sum", a + b - 3), equation("double", b - 2 * c), equation("given", c - k)],
        [a, b, c],
        [a],
    )
    assert [s.unknown for s in chain.order] == [c, b, a]
    assert [let.expr for let in chain.lets()] == [k, 2 * c, 3 - b]


def test_a_definition_is_never_solved_backwards() -> None:
    law = equation("law", b - sp.sin(a), defines=b)
    with pytest.raises(ChainError, match=r"1 equation is left for 2 unknowns \(a, b\), and no set"):
        ordered([law], [a, b], [a])


def test_unknown_is_solved_through_definitions() -> None:
    chain = ordered(
        [equation("balance", b + c - 6), equation("b", b - a, b), equation("c", c - 2 * a, c)],
        [a, b, c],
        [c],
    )
    assert [s.unknown for s in chain.order] == [a, b, c] or [s.unknown for s in chain.order] == [
        a,
        c,
    ]
    assert chain.lets()[0].expr == 2


def test_order_may_name_claims() -> None:
    equations = by_claim(
        [
            defining_equation(MadeUpClaim.SUM, a, b + c),
            defining_equation(MadeUpClaim.SHARE.format(b), b, 2 * c),
        ]
    )
    chain = Chain.of_claims(equations, [(MadeUpClaim.SHARE.format(b), c), (MadeUpClaim.SUM, a)])
    assert [(let.symbol, let.expr) for let in chain.lets()] == [(c, b / 2), (a, b + c)]
    with pytest.raises(
        ClaimError,
        match="nothing here states 'made-up share c'; near it: 'made-up sh",
    ):
        Chain.of_claims(equations, [(MadeUpClaim.SHARE.format(c), c)])


def test_a_nonlinear_step_is_refused() -> None:
    with pytest.raises(ChainError, match="not linear in a"):
        solve_linear(equation("square", a**2 - 4), a)


def test_open_case_list_ends_in_last_case() -> None:
    assert close_cases(Piecewise((a, k < 0), (b, k > 0))) == Piecewise((a, k < 0), (b, True))


def test_replacing_an_unknown_equation_is_refused() -> None:
    with pytest.raises(ChainError, match="no equation 99"):
        wang2017.SIDE.replace("99", equation("99", a))


def text_of(system: System) -> dict[str, str]:
    return {str(let.symbol): str(let.expr) for let in system.steps if hasattr(let, "expr")}


def dependents(changed: set[str], system: System) -> set[str]:
    """Names that depend on the changed ones, through any number of steps."""
    for step in system.steps:
        if {str(s).removesuffix("_2") for s in step.needs} & changed:
            changed = changed | {str(s) for s in step.defines}
    return changed


@pytest.mark.parametrize(
    ("number", "unknown"), [("5", "F_Ax"), ("8", "F_E"), ("18", "F_B1y"), ("14", "M_P")]
)
def test_edited_transcription_changes_a_single_step(number: str, unknown: str) -> None:
    original = wang2017.PAPER.equations[number]
    edited = equation(number, original.residual + q.m1 * q.g)
    before = derivation.build_printed_system(wang2017.SIDE, wang2017.FRAME)
    after = derivation.build_printed_system(wang2017.SIDE.replace(number, edited), wang2017.FRAME)
    old, new = text_of(before), text_of(after)
    assert {name for name in old if old[name] != new[name]} == {unknown}
    assert "F_support" in dependents({unknown}, after) or unknown == "M_P"


def test_printed_model_uses_only_kinematics_and_prints() -> None:
    """Every reaction of the printed model is solved from a numbered equation of the paper."""
    system = derivation.build_printed_system(wang2017.SIDE, wang2017.FRAME)
    kinematic = {s for step in derivation.build_device().steps for s in step.defines}
    assert system.lane is not None
    assert system.lane.shared is not None
    steps = (*system.lane.steps, *system.lane.shared.steps)
    sources = {str(step.symbol): step.source for step in steps if not set(step.defines) & kinematic}
    assert {name for name, source in sources.items() if not source.startswith("wang2017")} == {
        "F_E_loss",
        "F_support_x",
    }
    assert len(sources) > 25


def test_the_systems_know_no_paper() -> None:
    for module in ("derivation", "quantities"):
        text = (Path(derivation.__file__).parent / f"{module}.py").read_text(encoding="utf-8")
        assert "papers" not in text


def test_the_smallest_closed_set_is_solved_together() -> None:
    d = Quantity("d", "1", "test", "test")
    equations = [equation("far", d + a - 1), equation("one", a + b - 3), equation("two", a - b - k)]
    chain = ordered(equations, [a, b, d], [d])
    assert chain.order == [Together(("one", "two"), (a, b)), Solve("far", d)]
    pair, last = chain.steps()
    assert isinstance(pair, LinearSolve)
    solution = sp.Matrix(pair.matrix).LUsolve(sp.Matrix(pair.right))
    assert [sp.simplify(v) for v in solution] == [(3 + k) / 2, (3 - k) / 2]
    assert last == Let(d, 1 - a, "test")


def test_undetermined_unknowns_name_their_equations() -> None:
    with pytest.raises(
        ChainError,
        match=r"1 equation is left for 2 unknowns \(a, b\).*a stands in sum; b stands in sum",
    ):
        ordered([equation("sum", a + b - 3)], [a, b], [a])


def test_size_of_unknown_is_solved_by_cases() -> None:
    """Friction on a normal force among the unknowns: a + b = k, b = |a|/2 has two cases."""
    steps = solve_set([equation("along", a + b - k), equation("law", b - sp.Abs(a) / 2)], (a, b))
    for value, expected in ((3.0, 2.0), (-1.0, -2.0)):
        values: dict[sp.Basic, sp.Expr] = {k: sp.Float(value)}
        for step in steps:
            if isinstance(step, Let):
                values[step.symbol] = step.expr.xreplace(values)
            elif isinstance(step, LinearSolve):
                matrix, right = (
                    sp.Matrix(step.matrix).xreplace(values),
                    sp.Matrix(step.right).xreplace(values),
                )
                values |= dict(zip(step.symbols, matrix.LUsolve(right), strict=True))
        assert float(values[a]) == pytest.approx(expected)
        assert float(values[b]) == pytest.approx(abs(expected) / 2)


def test_nonlinear_set_is_refused() -> None:
    with pytest.raises(BlockError, match="not linear in a, b"):
        solve_set([equation("one", a * b - 1), equation("two", a + b - 3)], (a, b))
