"""Definitions of a text: tested where the mechanism has the same quantity, and the first suspect
where rows fail.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from tests.support.made_up import read_text, record_all

CRANK = '''
from derive import Mechanism, quantities
q = quantities("""
    phi | rad | crank angle
    omega | rad/s | crank speed | 94
    g | m/s2 | free fall | 9.81
    r | m | crank | 0.045
    l | m | rod | 0.16
    a | m | centroid of the rod, from A | 0.05
    m_r | kg | rod | 0.6
    J_r | kg m2 | rod, about its centroid | 0.0025
    m_s | kg | slider | 1.1
    G | N | gas force, against s | 500
""")
m = Mechanism("crank", q, angle=q.phi, speed=q.omega, gravity=q.g)
beta, s = m.coordinate("beta", "rad", "rod"), m.coordinate("s", "m", "slider")
cr, rd = m.frame("crank", q.phi), m.frame("rod", beta)
A = m.point("A", m.O, cr, q.r)
B, S = m.point("B", A, rd, q.l), m.point("S", m.O, m.world, s)
C = m.point("C", A, rd, q.a)
m.close(B, S, start={beta: 0, s: q.r + q.l})
crank, rod, slider = m.body("crank", cr), m.body("rod", rd, q.m_r, C, q.J_r), m.body("slider", m.world, q.m_s, S)
m.pin("O", crank, m.ground, m.O)
m.pin("A", rod, crank, A)
m.pin("B", slider, rod, B)
m.slide("guide", slider, m.ground, S)
m.force("gas", slider, S, m.vector(m.world, -q.G))
m.motor("M", crank, m.ground, m.O)
SYSTEM = m.system()
'''
X_C, Y_C = r"x_C = r\cos\varphi + a\cos\beta", r"y_C = \left(1 - \frac{a}{l}\right) r \sin\varphi"
RATE = r"\ddot y_C = -\left(1-\frac{a}{l}\right) r\,\omega^2\sin\varphi"
NEWTON = r"F_{Ay} - F_{By} - m_r g = m_r \ddot y_C"


def judge(folder: Path, *rows: str) -> list[dict[str, Any]]:
    body = "\n".join(f"\\begin{{equation}}\n{row}\n\\end{{equation}}" for row in rows)
    return record_all(read_text(folder, CRANK, body))


def list_verdicts(folder: Path, *rows: str) -> list[str]:
    return [record["verdict"] for record in judge(folder, *rows)]


def test_right_definitions_are_confirmed(tmp_path: Path) -> None:
    assert list_verdicts(tmp_path, X_C, Y_C, RATE, NEWTON) == ["confirmed"] * 4


def test_wrong_definition_is_found_and_what_follows_is_sound(tmp_path: Path) -> None:
    wrong = Y_C.replace(r"\sin", r"\cos")
    records = judge(tmp_path, X_C, wrong, RATE, NEWTON)
    assert [record["verdict"] for record in records] == [
        "confirmed",
        "misprint",
        "confirmed",
        "confirmed",
    ]
    assert records[1]["corrected_latex"] == Y_C


def test_error_beside_a_wrong_definition_keeps_its_name(tmp_path: Path) -> None:
    wrong, turned = Y_C.replace(r"\sin", r"\cos"), NEWTON.replace("- F_{By}", "+ F_{By}")
    records = judge(tmp_path, X_C, wrong, RATE, turned)
    assert [record["verdict"] for record in records] == [
        "confirmed",
        "misprint",
        "confirmed",
        "misprint",
    ]
    assert records[3]["corrected_latex"] == NEWTON


@pytest.mark.parametrize(
    "wrong",
    [
        Y_C.replace("1 -", "1 +"),
        Y_C.replace(r"\frac{a}{l}", r"\frac{l}{a}"),
        X_C.replace("+ a", "- a"),
        X_C.replace(r"a\cos", r"a\sin"),
    ],
)
def test_wrong_definition_without_rows_that_rest_on_it_is_found(tmp_path: Path, wrong: str) -> None:
    (record,) = judge(tmp_path, wrong)
    assert record["verdict"] == "misprint"
    assert record["corrected_latex"] in (X_C, Y_C)


@pytest.mark.parametrize(
    "definition",
    [
        r"y_C = -\left(1 - \frac{a}{l}\right) r \sin\varphi",  # downwards
        r"x_C = r\cos\varphi + a\cos\beta - r - l",  # from where the slider is farthest
        r"k = \frac{a}{l}\left(1 - \frac{a}{l}\right)",
        r"e = \sqrt{r^2 + a^2}",
    ],
)
def test_definitions_of_the_texts_own_are_not_accused(tmp_path: Path, definition: str) -> None:
    (record,) = judge(tmp_path, definition)
    assert record["verdict"] in ("untested", "confirmed")


def test_energy_is_tested(tmp_path: Path) -> None:
    moved = r"\frac{1}{2} m_s \dot s^2 + \frac{1}{2} m_r\left(\dot x_C^2 + \dot y_C^2\right)"
    right = rf"T = {moved} + \frac{{1}}{{2}} J_r \dot\beta^2"
    assert list_verdicts(tmp_path, X_C, Y_C, right)[2] == "confirmed"
    records = judge(tmp_path, X_C, Y_C, right.replace("J_r", "2 J_r"))
    assert records[2]["verdict"] == "misprint"
