"""Laws of a print that claims nothing: every balance of a press solved together, and errors of
several kinds in one.
"""

from functools import cache

import pytest

from derive import Mechanism, Paper, quantities
from derive.audit.laws import ChainLaws, judge_laws

q = quantities("""
    phi | rad   | crank
    w   | rad/s | speed                      | 12
    g   | m/s2  | free fall                  | 9.81
    r   | mm    | crank                      | 40
    l   | mm    | rod                        | 150
    m_1 | kg    | rod                        | 0.6
    J   | kg m2 | rod, about its centroid    | 0.0012
    M   | kg    | slider                     | 2
    nu  | 1/s   | a rate that nothing goes by | 5
""")


@cache
def press() -> tuple[Mechanism, dict[str, object]]:
    m = Mechanism("press", q, angle=q.phi, speed=q.w, gravity=q.g)
    beta, s = m.coordinate("beta", "rad", "rod"), m.coordinate("s", "m", "slider")
    crank, rod = m.frame("crank", q.phi), m.frame("rod", beta)
    A = m.point("A", m.O, crank, q.r)
    B, slot = m.point("B", A, rod, q.l), m.point("slot", m.O, m.world, s)
    m.close(B, slot, start={beta: 0, s: q.l + q.r})
    crank_body, rod_body = (
        m.body("crank", crank),
        m.body("rod", rod, q.m_1, m.point("C", A, rod, q.l / 2), q.J),
    )
    three = m.body("slider", m.world, q.M, slot)
    m.pin("O", crank_body, m.ground, m.O)
    m.pin("A", rod_body, crank_body, A)
    m.pin("B", three, rod_body, slot)
    m.slide("G", three, m.ground, slot)
    m.motor("M_in", crank_body, m.ground, m.O)
    m.system()
    names = {
        s.name: s for s in (*m.loops.all, *m.assembly.unknowns, *(step.symbol for step in m.named))
    }
    return m, names


def laws(**changed: str) -> dict[str, dict[str, object]]:
    """The findings on a print of all nine balances, without claims, some of them changed."""
    from sympy import cos, sin

    from derive import trial

    m, n = press()
    text = {
        "1": "F_Ox - F_Ax",
        "2": "F_Oy - F_Ay",
        "3": "M_in - q.r * (cos(q.phi) * F_Ay - sin(q.phi) * F_Ax)",
        "4": "F_Ax - F_Bx - q.m_1 * a_rod_x",
        "5": "F_Ay - F_By - q.m_1 * (a_rod_y + q.g)",
        "6": "q.l / 2 * (sin(beta) * (F_Ax + F_Bx) - cos(beta) * (F_Ay + F_By)) - q.J * beta_ddot",
        "7": "F_Bx - q.M * s_ddot",
        "8": "F_By + N_G - q.M * q.g",
        "9": "M_G",
    } | {number.removeprefix("n"): residual for number, residual in changed.items()}
    paper = Paper("press2026", "Written here")
    for number, residual in text.items():
        paper.equation(number, eval(residual, {"q": q, "sin": sin, "cos": cos, **n}))
    case = trial(m, paper)
    dynamics = case.subject.dynamics()
    assert case.chains is not None
    assert dynamics is not None
    return {
        f"{law['law']}, {law['unit']}": law
        for law in judge_laws("press2026", ChainLaws(*case.chains, dynamics))
    }


def test_a_right_print_keeps_every_law() -> None:
    laws_by_name = laws()
    assert {law["violation"] for law in laws_by_name.values()} == {0.0}
    names = " ".join(laws_by_name)
    for part in (
        "power",
        "rate of momentum",
        "angular momentum",
        "virtual work where beta",
        "forces on slider",
        "next to no speed",
        "square of the speed",
    ):
        assert part in names


@pytest.mark.parametrize(
    ("number", "wrong", "broken", "satisfied"),
    [
        ("n7", "F_Bx - 2 * q.M * s_ddot", "power", "square of the speed"),
        pytest.param(
            "n8",
            "F_By + N_G - 2 * q.M * q.g",
            "next to no speed",
            "square of the speed",
            marks=pytest.mark.long,
        ),
        (
            "n7",
            "F_Bx - q.M * s_ddot - q.M * q.nu * s_dot",
            "square of the speed",
            "next to no speed",
        ),
        (
            "n3",
            "M_in + q.r * (cos(q.phi) * F_Ay - sin(q.phi) * F_Ax)",
            "virtual work where phi",
            "forces on slider",
        ),
        pytest.param(
            "n6",
            "q.l / 2 * (sin(beta) * (F_Ax - F_Bx) - cos(beta) * (F_Ay + F_By)) - q.J * beta_ddot",
            "moments on rod",
            "forces on slider",
            marks=pytest.mark.long,
        ),
    ],
)
def test_an_error_breaks_laws_and_is_blamed(
    number: str, wrong: str, broken: str, satisfied: str
) -> None:
    laws_by_name = laws(**{number: wrong})
    assert [
        law["caused_by"]
        for name, law in laws_by_name.items()
        if broken in name and law["violation"]
    ]
    assert not [
        name for name, law in laws_by_name.items() if satisfied in name and law["violation"]
    ]
    assert {number for law in laws_by_name.values() for number in law["caused_by"]} == {
        number.removeprefix("n")
    }  # type: ignore[attr-defined]


def test_two_errors_are_distinguished() -> None:
    laws_by_name = laws(n7="F_Bx - 2 * q.M * s_ddot", n5="F_Ay - F_By - q.m_1 * (a_rod_y - q.g)")
    power_law = next(law for name, law in laws_by_name.items() if name.startswith("power"))
    assert power_law["caused_by"] == ["5", "7"]
    shares = {share["equation"]: share["shapley"] for share in power_law["shares"]}  # type: ignore[attr-defined]
    assert sum(shares.values()) == pytest.approx(power_law["violation"], rel=1e-3)
