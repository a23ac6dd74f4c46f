"""Papers about several mechanisms, written here: planted errors are found, what is written
otherwise is confirmed.

Some of their equations claim nothing: values alone judge them, and laws of the equations as a
whole.
"""

import json
import shutil
from pathlib import Path
from typing import Any

import pytest

from derive.__main__ import main as derive
from tests.support import own

HEAD = """
from sympy import Abs, cos, sin, sqrt, tan
from derive import Paper, loop, switch, trial, what
from {name} import m, q
told = [x.symbol for x in (*m.named, *m.reports)]
told += [symbol for _, symbols in m.list_centroids() for symbol in symbols]
n = {{s.name: s for s in (*m.loops.all, *m.assembly.unknowns, *told)}}
bodies = {{body.name: body for body in m.bodies}}
PAPER = Paper("written2026", "Written here")
"""
ARM = """
beta, gamma = m.loops.values
PAPER.equation("1", q.a * cos(q.phi) + q.b * cos(beta) - q.d - q.c * cos(gamma), loop("Bx"))
PAPER.equation("2", q.a * sin(q.phi) + q.b * sin(beta) - q.c * sin(gamma))
PAPER.defines("3", n["beta_dot"], q.a * q.omega * sin(gamma - q.phi) / (q.b * sin(beta - gamma)))
PAPER.defines("4", n["gamma_dot"], q.a * q.omega * sin(q.phi - beta) / (q.c * sin(gamma - beta)))
PAPER.defines("5", n["x_tip"], q.a * cos(q.phi) + q.p * cos(beta) - q.n * sin(beta), what("x_tip"))
PAPER.defines("6", n["F_return"], q.k * n["l_return"] - q.k * q.l_0, what("F_return"))
PAPER.equation("7", n["F_Ax"] - n["F_Bx"] - q.m_b * n["a_coupler_x"], m.balance(bodies["coupler"], "force", "x"))
lift = q.m_b * (n["a_coupler_y"] + q.g)
PAPER.equation("8", n["F_Ay"] - n["F_By"] - lift, m.balance(bodies["coupler"], "force", "y"))
PAPER.equation("9", n["F_Ox"] - n["F_Ax"] - q.m_a * n["a_crank_x"])
CASE = trial(m, PAPER)
"""
CAM = """
PAPER.defines("1", n["s"], q.h * sin(q.phi / 2) ** 2, what("s"))
PAPER.defines("2", n["s_ddot"], q.h * q.omega**2 * cos(q.phi) / 2)
PAPER.defines("3", n["F_spring"], q.F_0 + q.k * n["s"], what("F_spring"))
run, high = q.h * sin(q.phi) / 2, q.y_0 + n["s"]
drag = q.mu * Abs(n["N_guide"]) * switch(n["v_guide"], 1, -1)
rise = n["F_spring"] + q.m_s * q.g + drag + q.m_s * n["s_ddot"]
PAPER.equation("4", n["N_cam"] * high / sqrt(run**2 + high**2) - rise, m.balance(bodies["slide"], "force", "y"))
PAPER.equation("5", n["N_guide"] + n["N_cam"] * run / sqrt(run**2 + high**2))
PAPER.defines("6", n["M_in"], n["N_cam"] * run * high / sqrt(run**2 + high**2))
CASE = trial(m, PAPER)
"""
ARMS = """
one, two = m.loops.values
d1, d2, a1, a2 = (n[f"{c}_{d}"] for d in ("dot", "ddot") for c in ("shoulder", "elbow"))
across = q.m_2 * q.l_1 * q.c_2
own = q.J_2 + q.m_2 * q.c_2**2
PAPER.defines("1", n["x_G"], q.l_1 * cos(one) + q.l_2 * cos(one + two), what("x_G"))
PAPER.defines("2", n["M_1"], q.k_1 * (q.aim_1 - one) - q.d_1 * d1, what("M_1"))
PAPER.equation(
    "3",
    (own + across * cos(two)) * a1 + own * a2 + across * sin(two) * d1**2
    + q.m_2 * q.g * q.c_2 * cos(one + two) - n["M_2"],
    m.balance(bodies["forearm"], "moment"),
)
PAPER.equation(
    "4",
    (q.J_1 + q.m_1 * q.c_1**2 + own + q.m_2 * q.l_1**2 + 2 * across * cos(two)) * a1 + (own + across * cos(two)) * a2
    - across * sin(two) * (2 * d1 * d2 + d2**2) + (q.m_1 * q.c_1 + q.m_2 * q.l_1) * q.g * cos(one)
    + q.m_2 * q.g * q.c_2 * cos(one + two) - n["M_1"],
)
PAPER.defines("5", n["F_Ex"], q.m_2 * n["a_forearm_x"], m.balance(bodies["forearm"], "force", "x"))
PAPER.equation("6", n["F_Ey"] - q.m_2 * (q.g + n["a_forearm_y"]))
PAPER.equation("7", n["F_Ox"] - n["F_Ex"] - q.m_1 * n["a_upper_arm_x"])
CASE = trial(m, PAPER, until=0.6)
"""
PAPERS = {"transplanting_arm": ARM, "cam_follower": CAM, "manipulator": ARMS}
"""What is printed, by the example that it is about."""
PLANTED = {
    "transplanting_arm": [
        ("4", "sin(q.phi - beta)", "sin(q.phi + beta)", "misprint"),
        ("5", "- q.n * sin(beta)", "+ q.n * sin(beta)", "misprint"),
        ("8", '(n["a_coupler_y"] + q.g)', 'n["a_coupler_y"]', "incomplete"),
    ],
    "cam_follower": [
        ("2", "cos(q.phi) / 2)", "cos(q.phi))", "misprint"),
        ("4", '+ q.m_s * n["s_ddot"]\n', '- q.m_s * n["s_ddot"]\n', "misprint"),
    ],
    "manipulator": [
        ("2", "- q.d_1 * d1", "+ q.d_1 * d1", "misprint"),
        ("4", "2 * d1 * d2 + d2**2", "d1 * d2 + d2**2", "misprint"),
        ("5", 'n["a_forearm_x"]', '(n["a_forearm_x"] + q.g)', "misprint"),
    ],
}
"""Errors: the equation, what stands there, what is put there, the verdict."""


def judge_paper(folder: Path, name: str, text: str) -> dict[str, Any]:
    """The verdicts on a paper about an example."""
    shutil.copy(own.EXAMPLES / f"{name}.py", folder)
    (folder / "paper.py").write_text(HEAD.format(name=name) + text, encoding="utf-8")
    assert derive([str(folder / "paper.py")]) == 0
    content: dict[str, Any] = json.loads(
        (folder / "generated" / "audit.json").read_text(encoding="utf-8")
    )
    return content


@pytest.mark.parametrize(
    "name",
    [
        "cam_follower",
        *(pytest.param(n, marks=pytest.mark.long) for n in ("transplanting_arm", "manipulator")),
    ],
)
def test_a_paper_without_errors_stands_and_keeps_the_laws(name: str, tmp_path: Path) -> None:
    judged = judge_paper(tmp_path, name, PAPERS[name])
    assert {
        e["equation"]: e["verdict"] for e in judged["equations"] if e["verdict"] != "confirmed"
    } == {}
    assert judged["laws"]
    assert {(law["violation"], *law["caused_by"]) for law in judged["laws"]} == {(0.0,)}
    assert judged["papers"]["written2026"] == {"title": "Written here", "model": name}
    assert (tmp_path / "generated" / f"{name}.toml").is_file()


@pytest.mark.parametrize(
    "name",
    ["cam_follower", "manipulator", pytest.param("transplanting_arm", marks=pytest.mark.long)],
)
def test_only_planted_errors_are_reported(name: str, tmp_path: Path) -> None:
    text = PAPERS[name]
    for _, right, wrong, _ in PLANTED[name]:
        assert text.count(right) == 1
        text = text.replace(right, wrong)
    judged = judge_paper(tmp_path, name, text)
    expected = {number: verdict for number, _, _, verdict in PLANTED[name]}
    assert {
        e["equation"]: e["verdict"] for e in judged["equations"] if e["verdict"] != "confirmed"
    } == expected
    blamed = {number for law in judged["laws"] for number in law["caused_by"]}
    assert blamed <= expected.keys()
    assert all(law["owed"] for law in judged["laws"] if law["violation"])
