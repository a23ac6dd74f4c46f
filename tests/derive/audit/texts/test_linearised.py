"""Linearised rows are sound to first order about an equilibrium, and no other; what is wrong in
them is found.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from tests.support.made_up import read_text, record_all

CART = '''
from derive import Mechanism, quantities
q = quantities("""
    g | m/s2 | free fall | 9.81
    M | kg | cart | 1.0
    m | kg | particle | 0.3
    l | m | pole | 2.0
    F | N | force on the cart | 3
""")
m = Mechanism("cp", q, gravity=q.g)
x, t = m.coordinate("x", "m", "cart"), m.coordinate("theta", "rad", "pole")
f = m.frame("pole", t, (0, 0, -1))
C = m.point("C", m.O, m.world, x)
P = m.point("P", C, f, 0, q.l)
cart, pole = m.body("cart", m.world, q.M, C), m.body("pole", f, q.m, P)
m.slide("rail", cart, m.ground, C)
m.pin("A", pole, cart, C)
m.force("push", cart, C, m.vector(m.world, q.F))
SYSTEM = m.system()
'''
PENDULUM = """
from derive import Mechanism, quantities
q = quantities("g | m/s2 | free fall | 9.81\\nm | kg | bob | 0.4\\nl | m | rod | 0.7")
m = Mechanism("pendulum", q, gravity=q.g)
t = m.coordinate("theta", "rad", "rod")
f = m.frame("rod", t)
P = m.point("P", m.O, f, 0, -q.l)
rod = m.body("rod", f, q.m, P)
m.pin("A", rod, m.ground, m.O)
SYSTEM = m.system()
"""


def judge(folder: Path, mechanism: str, *rows: str, words: str = "") -> list[dict[str, Any]]:
    text = "\n\n".join([words, *(f"$$ {row} $$" for row in rows)])
    return record_all(read_text(folder, mechanism, text, suffix=".md"))


SOUND = (
    r"\ddot{x} = - \frac{m g}{M}\theta + \frac{1}{M}F",
    r"\ddot{\theta} = \frac{g(M+m)}{l M}\theta - \frac{1}{l M}F",
    r"(M+m)\ddot{x} + m l \ddot{\theta} = F",
    r"\ddot{x} + l\ddot{\theta} = g\theta",
)
WRONG = (
    r"\ddot{x} = \frac{m g}{M}\theta + \frac{1}{M}F",
    r"\ddot{\theta} = \frac{g(M-m)}{l M}\theta - \frac{1}{l M}F",
    r"(M+m)\ddot{x} + 2 m l \ddot{\theta} = F",
    r"\ddot{x} + l\ddot{\theta} = g\dot{\theta}",
    r"\ddot{x} + l\ddot{\theta} = 0",
    r"\frac{d}{dt}\left(\dot{\theta}^2\right) = 0",
    r"(M+m)\ddot{x} + m l \ddot{\theta}\cos\theta + m l \dot{\theta}^2\sin\theta = F",
    r"m l \ddot{x} \cos\theta + m l^2 \ddot{\theta} - m g l \theta = 0",
)


def test_linearised_rows_are_sound(tmp_path: Path) -> None:
    records = judge(tmp_path, CART, *SOUND)
    assert [record["verdict"] for record in records] == ["confirmed"] * len(SOUND)
    assert all(
        "theta = 0" in record["domain"] and "pi" not in record["domain"] for record in records
    )


def test_wrong_linearised_rows_and_wrong_products_are_accused(tmp_path: Path) -> None:
    """A row with a product or a function of what moves was not linearised, unless the text says
    so.
    """
    records = judge(tmp_path, CART, *WRONG)
    assert {record["verdict"] for record in records} <= {"misprint", "incomplete", "contradicted"}


@pytest.mark.parametrize(
    "words",
    [
        "For small angles,",
        "Linearising about the upright position,",
        r"With $\sin\theta \approx \theta$,",
    ],
)
def test_announced_approximations_may_keep_products(tmp_path: Path, words: str) -> None:
    row = r"(M+m)\ddot{x} + m l \ddot{\theta} - m l \dot{\theta}^2\theta = F"
    (before,), (after,) = judge(tmp_path, CART, row), judge(tmp_path, CART, row, words=words)
    assert (before["verdict"] == "confirmed", after["verdict"]) == (False, "confirmed")
    wrong = row.replace("= F", "= -F")
    (record,) = judge(tmp_path, CART, wrong, words=words)
    assert record["verdict"] != "confirmed"


def test_each_equilibrium_has_its_own_linearisation(tmp_path: Path) -> None:
    hanging = r"m l^2 \ddot{\theta} + m g l \theta = 0"
    inverted = r"m l^2 \ddot{\theta} - m g l (\theta - \pi) = 0"
    neither = r"m l^2 \ddot{\theta} - m g l \theta = 0"
    records = judge(tmp_path, PENDULUM, hanging, inverted, neither)
    assert [record["verdict"] == "confirmed" for record in records] == [True, True, False]
    assert "theta = 0" in records[0]["domain"]
    assert "theta = pi" in records[1]["domain"]
