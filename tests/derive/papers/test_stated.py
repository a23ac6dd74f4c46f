"""A paper of one's own against a mechanism of one's own: planted errors are found and corrected, a
clean one stands.
"""

import json
import random
import shutil
from pathlib import Path

import mpmath
import pytest

from derive import Mechanism, quantities
from derive.__main__ import main as derive
from derive.audit.user_mechanism.trial import build_subject
from derive.mechanics.statement import MechanismError
from tests.support.structure import ROOT

WRONG = {"2": "misprint", "4": "misprint", "5": "incomplete"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("own")
    for name in ("slider_crank.py", "slider_crank_paper.py"):
        shutil.copy(ROOT / "docs" / "examples" / name, place)
    return place


def verdicts(folder: Path, text: str, name: str) -> dict[str, dict[str, object]]:
    (folder / f"{name}.py").write_text(text, encoding="utf-8")
    assert derive([str(folder / f"{name}.py"), "--out", str(folder / name)]) == 0
    return {
        e["equation"]: e
        for e in json.loads((folder / name / "audit.json").read_text())["equations"]
    }


def test_planted_errors_get_their_corrections(folder: Path) -> None:
    judged = verdicts(folder, (folder / "slider_crank_paper.py").read_text(), "wrong")
    assert {number: entry["verdict"] for number, entry in judged.items()} == dict.fromkeys(
        "136", "confirmed"
    ) | WRONG
    assert "sign of l*sin(beta)" in str(judged["2"]["correction"])
    assert "sign of l_0" in str(judged["4"]["correction"])
    assert "c*g*m_r*cos(beta)" in str(judged["5"]["terms"])


def test_the_same_without_errors_stands(folder: Path) -> None:
    text = (folder / "slider_crank_paper.py").read_text()
    for wrong, right in (
        ("+ q.l * sin(beta), loop", "- q.l * sin(beta), loop"),
        ("(l_spring + q.l_0)", "(l_spring - q.l_0)"),
        ("(a_y * cos(beta) - a_x * sin(beta))", "((a_y + q.g) * cos(beta) - a_x * sin(beta))"),
    ):
        assert wrong in text
        text = text.replace(wrong, right)
    judged = verdicts(folder, text, "right")
    assert {str(entry["verdict"]) for entry in judged.values()} == {"confirmed"}


def test_decision_points_satisfy_loops_and_balances(folder: Path) -> None:
    q = quantities("""
        phi | rad | crank | 0
        w   | rad/s | speed | 12
        r   | mm | crank | 40 | 30 45
        l   | mm | rod | 150
        M   | kg | slider | 2
    """)
    m = Mechanism("press", q, angle=q.phi, speed=q.w)
    beta, s = m.coordinate("beta", "rad", "rod"), m.coordinate("s", "m", "slider")
    A = m.point("A", m.O, m.frame("crank", q.phi), q.r)
    B, slot = m.point("B", A, m.frame("rod", beta), q.l), m.point("slot", m.O, m.world, s)
    m.close(B, slot, start={beta: 0, s: q.l + q.r})
    crank_body, rod_body = (
        m.body("crank", m.frame("crank", q.phi)),
        m.body("rod", m.frame("rod", beta)),
    )
    three = m.body("slider", m.world, q.M, slot)
    m.pin("O", crank_body, m.ground, m.O)
    m.pin("A", rod_body, crank_body, A)
    m.pin("B", three, rod_body, slot)
    m.slide("G", three, m.ground, slot)
    m.motor("M_in", crank_body, m.ground, m.O)
    subject = build_subject(m)
    with mpmath.workdps(55):
        for values in (*subject.reference(5), subject.admissible(random.Random(3))):
            across = values[q.r] * mpmath.sin(values[q.phi])
            place = values[q.r] * mpmath.cos(values[q.phi]) + mpmath.sqrt(
                values[q.l] ** 2 - across**2
            )
            assert abs(values[s] - place) < mpmath.mpf(10) ** -45
            assert (
                abs(values[next(v for v in values if str(v) == "law_power")])
                < mpmath.mpf(10) ** -40
            )


def test_a_table_without_a_value_is_named() -> None:
    q = quantities("phi | rad | crank\n w | rad/s | speed | 12\n M | kg | wheel")
    m = Mechanism("wheel", q, angle=q.phi, speed=q.w)
    body = m.body("wheel", m.frame("wheel", q.phi), q.M, m.O, q.M * 0)
    m.pin("O", body, m.ground, m.O)
    m.motor("M_in", body, m.ground, m.O)
    with pytest.raises(MechanismError, match="the table gives no value of M"):
        build_subject(m).reference(3)
