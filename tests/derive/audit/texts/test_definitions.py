"""Definitions of a text: tested where the mechanism has the same quantity, and the first suspect
where rows fail.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from derive.audit.texts.changes import shorten_latex
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


MOTOR = r"M = k (F_{Ay}\cos\varphi - F_{Ax}\sin\varphi)"
PLACE = r"s = k\cos\varphi + \sqrt{l^2 - r^2\sin^2\varphi}"


def test_names_defined_after_their_use_are_known(tmp_path: Path) -> None:
    turned = NEWTON.replace("- F_{By}", "+ F_{By}")
    records = judge(tmp_path, RATE, NEWTON, turned, X_C, Y_C.replace(r"\sin", r"\cos"))
    assert [record["verdict"] for record in records] == [
        "confirmed",
        "confirmed",
        "misprint",
        "confirmed",
        "misprint",
    ]
    assert [records[place]["corrected_latex"] for place in (2, 4)] == [NEWTON, Y_C]


def test_later_definition_of_another_unit_is_not_what_a_row_speaks_of(tmp_path: Path) -> None:
    records = judge(tmp_path, r"s = r\cos\varphi + h\cos\beta", r"h = m_r r")
    assert [record["verdict"] for record in records] == ["not judged", "untested"]


@pytest.mark.parametrize("mixing", [r"k = r + m_r", r"k = \sqrt{r^2 + a}", r"k = l (J_r + m_r a)"])
def test_definition_that_mixes_units_is_an_error_of_the_text(tmp_path: Path, mixing: str) -> None:
    records = judge(tmp_path, mixing, MOTOR, r"w = k a")
    assert records[0]["verdict"] == "contradicted"
    assert "have different units" in records[0]["finding"]
    assert [record["verdict"] for record in records[1:]] == ["not judged"] * 2
    assert all("(1), which defines it, mixes units" in record["finding"] for record in records[1:])


@pytest.mark.parametrize("definition", [r"k = 3 + r", r"k = \cos\varphi + r", r"k = \sin(2 a)"])
def test_pure_numbers_in_a_definition_may_stand_for_quantities(
    tmp_path: Path, definition: str
) -> None:
    assert list_verdicts(tmp_path, definition) == ["not judged"]


def test_definition_is_suspected_before_two_rows_that_rest_on_it(tmp_path: Path) -> None:
    records = judge(tmp_path, r"k = r + a", MOTOR, PLACE)
    assert [record["verdict"] for record in records] == ["contradicted", "confirmed", "confirmed"]
    assert "holds if it is r" in records[0]["finding"]


def test_row_that_rests_on_an_untested_definition_says_so(tmp_path: Path) -> None:
    records = judge(tmp_path, r"k = r + a", MOTOR)
    assert [record["verdict"] for record in records] == ["untested", "misprint"]
    assert "rests on what nothing tests: k of (1)" in records[1]["finding"]


def test_definition_that_sound_rows_rest_on_is_no_suspect(tmp_path: Path) -> None:
    wrong = MOTOR.replace("-", "+").replace("k", "k \\frac{l}{a}")
    sound = r"x_C = r\cos\varphi + k l\cos\beta"
    records = judge(tmp_path, r"k = \frac{a}{l}", sound, wrong)
    assert [record["verdict"] for record in records[:2]] == ["untested", "confirmed"]
    assert "what rests on it holds: (2)" in records[0]["finding"]
    assert records[2]["verdict"] not in ("confirmed", "not judged")
    assert "nothing tests" not in records[2]["finding"]


def test_rates_are_tested(tmp_path: Path) -> None:
    rate = r"\omega_r = -\frac{r\omega\cos\varphi}{l\cos\beta}"
    assert list_verdicts(tmp_path, rate) == ["confirmed"]
    assert list_verdicts(tmp_path, rate.replace("-", "")) == ["untested"]


@pytest.mark.parametrize(
    ("row", "holds"),
    [
        (r"\beta = 2\pi - \arcsin\left(\frac{r}{l}\sin\varphi\right)", True),
        (r"\varphi = \operatorname{atan2}(r\sin\varphi, r\cos\varphi)", True),
        (r"\beta = \pi - \arcsin\left(\frac{r}{l}\sin\varphi\right)", False),
        (r"\varphi = \operatorname{atan2}(r\cos\varphi, r\sin\varphi)", False),
        (r"r\varphi = r\operatorname{atan2}(r\sin\varphi, r\cos\varphi)", False),  # an arc
    ],
)
def test_angles_are_equal_up_to_turns(tmp_path: Path, row: str, holds: bool) -> None:
    (record,) = judge(tmp_path, row)
    assert (record["verdict"] == "confirmed") is holds
    assert ("whole turns" in record["finding"]) is holds


@pytest.mark.parametrize(
    ("row", "corrected"),
    [
        (
            r"\ddot s = -r\omega^2\cos\varphi - l\ddot\beta\sin\beta",
            r"\ddot s = -r\omega^2\cos\varphi - l\ddot\beta\sin\beta - \dot{\beta}^2 l \cos \beta",
        ),
        (r"G = \frac{1}{2} F_{Bx} - m_s\ddot s", r"G = F_{Bx} - m_s\ddot s"),
        (
            r"M = -r (F_{Ay}\cos\varphi - F_{Ax}\sin\varphi)",
            r"M = r (F_{Ay}\cos\varphi - F_{Ax}\sin\varphi)",
        ),
        (
            r"M = r (-F_{Ay}\cos\varphi + F_{Ax}\sin\varphi)",
            r"M = -r (-F_{Ay}\cos\varphi + F_{Ax}\sin\varphi)",
        ),
    ],
)
def test_corrected_rows_read_as_print(tmp_path: Path, row: str, corrected: str) -> None:
    rate = r"l\dot\beta\cos\beta = -r\omega\cos\varphi"
    record, _ = judge(tmp_path, row, rate)
    assert " ".join(record["corrected_latex"].split()) == corrected


def test_second_statement_of_a_definition_is_repaired_to_it(tmp_path: Path) -> None:
    first = r"v_B = -r\omega\frac{\sin(\varphi-\beta)}{\cos\beta}"
    records = judge(tmp_path, first, first.replace(r"\varphi-", r"\varphi+"))
    assert [record["verdict"] for record in records] == ["confirmed", "misprint"]
    assert records[1]["corrected_latex"] == first


def test_words_of_repairs_end_between_names() -> None:
    piece = shorten_latex(r"r\,\omega\frac{\sin(\varphi-\beta)}{\cos\beta} + l\dot\beta\sin\beta")
    assert piece == r"r\,\omega\frac{\sin(\varphi-\beta)}{\cos\beta} ..."
    assert shorten_latex(r"F_{Ay}\cos\varphi - F_{Ax}\sin\varphi + m_r g") == (
        r"F_{Ay}\cos\varphi - F_{Ax} ..."
    )
    assert shorten_latex(r"a + b") == "a + b"
