"""Laws of every order of solution: what it finds fulfils the equations, and each of them is spent
once.
"""

import random
from collections.abc import Callable, Iterable, Mapping

import pytest
import sympy as sp

from derive.chain import (
    BlockError,
    Chain,
    ChainError,
    Solve,
    Together,
    closed_set,
    friction_states,
    match_equations,
    ordered,
    select_solvable,
    solve_set,
)
from derive.equations import Definition, Equation
from derive.functions import switch
from derive.model import Let, LinearSolve, Step
from derive.quantity import Quantity

UNKNOWNS = tuple(Quantity(f"u{i}", "1", "test", "test") for i in range(8))
a, b, c, d, e = UNKNOWNS[:5]
k = Quantity("k", "1", "test", "test")
Values = Mapping[sp.Basic, sp.Expr]


def equation(number: str, residual: sp.Expr, defines: Quantity | None = None) -> Equation:
    return Equation(number, residual, "test", Definition("test"), defines=defines)


def after(steps: Iterable[Step], initial: Values) -> Values:
    """What steps give, in exact numbers; each needs nothing but what is known before it."""
    values = dict(initial)
    for step in steps:
        assert set(step.needs) <= values.keys()
        if isinstance(step, LinearSolve):
            matrix, right = (
                sp.Matrix(step.matrix).xreplace(values),
                sp.Matrix(step.right).xreplace(values),
            )
            values |= dict(zip(step.symbols, matrix.LUsolve(right), strict=True))
        else:
            assert isinstance(step, Let)
            values[step.symbol] = step.expr.xreplace(values)
    return values


def system(seed: int) -> list[Equation]:
    """Linear equations in random order, of which some give an unknown by others, some are loops,
    some define.
    """
    rng = random.Random(seed)
    equations, count = [], len(UNKNOWNS)
    for i, unknown in enumerate(UNKNOWNS):
        neighbours = rng.sample(UNKNOWNS[:i], min(i, 2)) + rng.sample(
            UNKNOWNS, rng.choice((0, 0, 1))
        )
        terms = [rng.choice((-3, -2, 2, 3)) * other for other in neighbours if other != unknown]
        residual = (count + 7) * unknown + sp.Add(*terms) - rng.randint(1, 9) * k
        equations.append(equation(f"e{i}", residual, unknown if rng.random() < 0.4 else None))
    rng.shuffle(equations)
    return equations


def spent(chain: Chain) -> list[str]:
    return [number for solve in chain.order for number in solve.equations]


@pytest.mark.parametrize("seed", range(12))
def test_solution_of_an_order_satisfies_equations(seed: int) -> None:
    equations = system(seed)
    chain = ordered(equations, UNKNOWNS, UNKNOWNS)
    solution = after(chain.steps(), {k: sp.Rational(2, 3)})
    assert [e.residual.xreplace(solution) for e in equations] == [0] * len(equations)
    assert sorted(spent(chain)) == sorted(e.number for e in equations)
    assert sorted((u for s in chain.order for u in s.unknowns), key=str) == list(UNKNOWNS)


@pytest.mark.parametrize("seed", range(4))
def test_order_ends_with_requested_unknown(seed: int) -> None:
    equations = system(seed)
    first, *_ = ordered(equations, UNKNOWNS, UNKNOWNS).order
    assert ordered(equations, UNKNOWNS, first.unknowns).order == [first]


def test_definition_is_used_once() -> None:
    equations = [
        equation("balance", b + c - 6),
        equation("b", b - a, b),
        equation("c", c - 2 * a, c),
    ]
    chain = ordered(equations, [a, b, c], [b, c])
    assert chain.order[0] == Solve("balance", a, (("b", b), ("c", c)))
    assert chain.order[0].involved == chain.spent == {"balance", "b", "c"}
    assert spent(chain) == ["balance", "b", "c"]


def test_a_balance_with_two_roots_behind_definitions_is_no_way() -> None:
    equations = [equation("balance", b + c - 6), equation("b", b - a, b), equation("c", c - d, c)]
    with pytest.raises(ChainError, match=r"3 equations are left for 4 unknowns \(u0, u1, u2, u3\)"):
        ordered(equations, [a, b, c, d], [c])


def test_underdetermined_error_names_equations() -> None:
    with pytest.raises(
        ChainError,
        match=r"u0 stands in sum; u1 stands in sum, far; u2 stands in far; u3 stands in none$",
    ):
        ordered([equation("sum", a + b - 3), equation("far", b + c - 1)], [a, b, c, d], [a])


@pytest.mark.parametrize("find", [lambda es, us: ordered(es, us, us), select_solvable])
def test_sizes_are_solved_by_cases(find: Callable[[list[Equation], list[Quantity]], Chain]) -> None:
    chain = find([equation("size", a + sp.Abs(a) / 2 - k)], [a])
    assert chain.order == [Together(("size",), (a,))]
    with pytest.raises(ChainError, match="equations size have to be solved together"):
        chain.lets()
    chain = find([equation("along", a + b - k), equation("friction", b - sp.Abs(a) / 2, b)], [a, b])
    assert chain.order == [Together(("along", "friction"), (a, b))]
    assert after(chain.steps(), {k: sp.Integer(-3)})[a] == -6


@pytest.mark.parametrize("seed", range(6))
def test_solvable_unknowns_are_solved_and_others_assumed(seed: int) -> None:
    """Two equations are missing, one is a product: the others still hold of what is found, whatever
    the rest is.
    """
    equations = [e for e in system(seed) if e.number not in ("e0", "e5")]
    equations.append(equation("product", a * UNKNOWNS[5] - k))
    chain = select_solvable(equations, UNKNOWNS)
    solved_for = [u for solve in chain.order for u in solve.unknowns]
    assumed = {u: sp.Rational(i + 2, 7) for i, u in enumerate(UNKNOWNS) if u not in solved_for}
    assert assumed
    solution = after(chain.steps(), {k: sp.Rational(2, 3), **assumed})
    assert all(e.residual.xreplace(solution) == 0 for e in equations if e.number in chain.spent)
    assert chain.equations == {e.number: e for e in equations}
    assert "product" not in chain.spent or len(assumed) == 1


def test_nonlinear_equations_are_ignored() -> None:
    chain = select_solvable([equation("square", a**2 - k), equation("sum", a + b - k)], [a, b])
    assert chain.order == [Solve("sum", b)]
    pair = [equation("product", a * b - k), equation("sum", a + b - k), equation("last", c - a)]
    assert select_solvable(pair, [a, b, c]).order == [Solve("last", c)]


@pytest.mark.parametrize(("value", "count"), [(3, 2), (-3, 0), (0, 1)])
def test_states_of_friction_are_counted(value: int, count: int) -> None:
    """a + 2 |a| = k holds in two states for k > 0, in none for k < 0; where both meet it is one."""
    steps = solve_set([equation("along", a + b - k), equation("law", b - 2 * sp.Abs(a))], (a, b))
    solution = after(steps, {k: sp.Integer(value)})
    assert solution[friction_states(a)] == count
    assert not count or solution[a] + 2 * abs(solution[a]) == value


@pytest.mark.parametrize("values", [(3, 1), (-3, 1), (3, -7), (-2, -7)])
def test_two_sizes_have_four_exclusive_cases(values: tuple[int, int]) -> None:
    equations = [equation("one", a + sp.Abs(b) / 3 - k), equation("two", b - sp.Abs(a) / 4 - c)]
    solution = after(
        solve_set(equations, (a, b)), {k: sp.Integer(values[0]), c: sp.Integer(values[1])}
    )
    assert [e.residual.xreplace(solution) for e in equations] == [0, 0]
    assert solution[friction_states(a)] == 1


@pytest.mark.parametrize("load", [6, -6])
def test_sign_of_unknown_decides_case(load: int) -> None:
    """As the flanks of teeth do: ``b`` presses with another lever on either side; definitions are
    eliminated.
    """
    lever = switch(a, sp.Integer(2), sp.Integer(-3))
    block = [
        equation("lever", b - a / lever, b),
        equation("sum", c - b, c),
        equation("load", a + c - k),
    ]
    steps = solve_set(block, (a, b, c))
    values = after(steps, {k: sp.Integer(load)})
    assert [e.residual.xreplace(values) for e in block] == [0, 0, 0]
    assert values[a] == (4 if load > 0 else -9)
    assert values[friction_states(a)] == 1
    assert not any(isinstance(step, LinearSolve) for step in steps)


def test_too_many_sizes_are_refused() -> None:
    sizes = [equation(str(u), u + sp.Abs(u) / 2 - k) for u in UNKNOWNS[:5]]
    with pytest.raises(BlockError, match=r"u0.*u4.*at most 4"):
        solve_set(sizes, UNKNOWNS[:5])
    assert len(solve_set(sizes[:4], UNKNOWNS[:4])) == 2**4 + 4 + 1
    names = [str(u) for step in solve_set(sizes[:1], UNKNOWNS[:1]) for u in step.defines]
    assert names == ["u0_case1", "u0_case2", "u0", "states_u0"]


def test_matching_is_maximal() -> None:
    """Where an equation's only unknown is taken, the one that took it makes way."""
    equations = [equation("both", a + b), equation("first", a - k), equation("none", k - 1)]
    assert {u: e.number for u, e in match_equations(equations, [a, b]).items()} == {
        a: "first",
        b: "both",
    }
    assert {u: e.number for u, e in match_equations(equations[:1], [a, b]).items()} == {a: "both"}


def test_a_closed_set_is_the_smallest_and_whole() -> None:
    pair = [equation("one", a + b - k), equation("two", a - b)]
    triple = [
        equation("three", c + d - a),
        equation("four", c - 2 * d - e),
        equation("five", c + e),
    ]
    chosen, unknowns = closed_set([*triple, *pair], UNKNOWNS)
    assert ([e.number for e in chosen], unknowns) == (["one", "two"], [a, b])
    assert closed_set(triple, UNKNOWNS) == ([], [])
    assert [e.number for e in closed_set(triple, UNKNOWNS[2:])[0]] == ["three", "four", "five"]
