"""A paper on trial: six equations about the slider-crank beside this file, three of them wrong in one place each.

Numbers that it prints stand in slider_crank_numbers.toml. An equation may also stand here without a claim.
"""

from slider_crank import m, q
from sympy import cos, sin

from derive import Paper, loop, trial, what

known = {
    symbol.name: symbol
    for symbol in (*m.loops.all, *m.assembly.unknowns, *(let.symbol for let in m.named))
}
bodies = {body.name: body for body in m.bodies}
beta, s = m.loops.values
a_x, a_y, beta_ddot, F_Bx, F_By, N, F_spring, l_spring = (
    known[n]
    for n in ("a_rod_x", "a_rod_y", "beta_ddot", "F_Bx", "F_By", "N_guide", "F_spring", "l_spring")
)

PAPER = Paper("invented2026", "An invented paper on the slider-crank, with planted errors")
PAPER.defines("1", s, q.r * cos(q.phi) + q.l * cos(beta), loop("Bx"))
PAPER.equation(
    "2", q.e - q.r * sin(q.phi) + q.l * sin(beta), loop("By")
)  # planted: the sign of the rod
PAPER.equation("3", F_By + N - q.m_s * q.g, m.balance(bodies["slider"], "force", "y"))
PAPER.defines(
    "4", F_spring, q.k * (l_spring + q.l_0), what("F_spring")
)  # planted: the sign of the free length
PAPER.equation(  # planted: the rod's weight is left out
    "5",
    (q.e - q.r * sin(q.phi)) * F_Bx
    - (s - q.r * cos(q.phi)) * F_By
    - q.c * q.m_r * (a_y * cos(beta) - a_x * sin(beta))
    - q.J * beta_ddot,
    m.balance(bodies["rod"], "moment"),
)
PAPER.defines("6", l_spring, q.wall - s, what("l_spring"))

CASE = trial(m, PAPER)
