"""Typical equations of mechanism papers, each with what it must mean in SymPy, and those that must
be refused.
"""

import re

import pytest
import sympy as sp

from derive import Formulas, quantities
from derive.audit.texts.documents import build_document
from derive.audit.texts.formula import Bracket, FormulaError, FunctionCall, list_nodes, read_formula
from derive.audit.texts.interpretation import interpret_formula
from derive.audit.texts.names import NameTable, StatedNames, spell_name, to_scalar
from derive.audit.texts.values import MatrixValue, OperandError

Q = quantities(
    "\n".join(
        f"{name} | {unit} | {name}"
        for unit, names in {
            "m": "x y s l l_1 l_2 r r_1 r_2 e d R h x_1 y_1 x_B u",
            "rad": "theta theta_1 theta_2 phi beta alpha q_1 q_2 psi gamma",
            "rad/s": "omega omega_1 omega_2 theta_dot theta_1_dot theta_2_dot q_1_dot",
            "rad/s2": "theta_ddot theta_1_ddot theta_2_ddot epsilon",
            "m/s": "v s_dot x_dot y_dot v_x v_y",
            "m/s2": "g s_ddot x_ddot y_ddot a a_x",
            "kg": "m m_1 m_2 M",
            "kg m2": "J J_1 I I_1",
            "N": "F F_x F_y F_12x F_12y N R_x F_f P",
            "N m": "T M_1 tau tau_1 M_in",
            "N/m": "k k_1",
            "N s/m": "c",
            "1": "mu n z_1 z_2 i kappa eta lam epsilon_0",
            "s": "time t_1",
            "J": "E L V K",
            "m2": "A",
            "N/m2": "p p_0",
        }.items()
        for name in names.split()
    )
)
NAMES = {
    "t": "time",
    r"\lambda": "lam",
    r"\epsilon": "epsilon",
    r"M_{in}": "M_in",
    "c_#": "cos(theta_#)",
    "s_#": "sin(theta_#)",
}


def read(latex, table=None, macros=None):
    """Return the residuals of a formula as expressions of Q."""
    meanings = {
        spell_name(name): text for name, text in (NAMES if table is None else table).items()
    }
    names = StatedNames(Formulas("names", given=Q), dict(Q), NameTable(meanings))
    residuals = interpret_formula(read_formula(latex, macros), names).residuals(names)
    return [sp.sympify(left.value) - sp.sympify(right.value) for _, _, left, right in residuals]


TYPICAL = [
    (r"x = r\cos\theta + l\cos\beta", "x - r*cos(theta) - l*cos(beta)"),
    (
        r"y_1 = l_1 \sin(\theta_1) + l_2\sin(\theta_1+\theta_2)",
        "y_1 - l_1*sin(theta_1) - l_2*sin(theta_1 + theta_2)",
    ),
    (r"\dot{x} = -r\dot\theta\sin\theta", "x_dot + r*theta_dot*sin(theta)"),
    (
        r"\ddot{x} = -r\ddot{\theta}\sin\theta - r\dot{\theta}^2\cos\theta",
        "x_ddot + r*theta_ddot*sin(theta) + r*theta_dot**2*cos(theta)",
    ),
    (r"T = \frac{1}{2} m v^2", "T - m*v**2/2"),
    (r"E = \frac12 m v^{2} + \frac12 J\dot\theta^2", "E - m*v**2/2 - J*theta_dot**2/2"),
    (r"V = -m g l \cos\theta", "V + m*g*l*cos(theta)"),
    (r"m\ddot x + c\dot x + k x = F", "m*x_ddot + c*x_dot + k*x - F"),
    (r"J \ddot\theta = M_1 - F_x r \sin \theta", "J*theta_ddot - M_1 + F_x*r*sin(theta)"),
    (r"m \ddot{x} = F_{12x} - F_f \label{eq:a}", "m*x_ddot - F_12x + F_f"),
    (r"F_f = \mu N \operatorname{sgn}(v)", "F_f - mu*N*sign(v)"),
    (r"\beta = \arcsin\left(\frac{e - r\sin\theta}{l}\right)", "beta - asin((e - r*sin(theta))/l)"),
    (r"\theta_2 = \tan^{-1}\frac{y}{x}", "theta_2 - atan(y/x)"),
    (r"\theta = \operatorname{atan2}(y, x)", "theta - atan2(y, x)"),
    (r"\theta = \arctan(y, x)", "theta - atan2(y, x)"),
    (r"l^2 = r^2 + d^2 - 2rd\cos\theta", "l**2 - r**2 - d**2 + 2*r*d*cos(theta)"),
    (r"r_1 = \sqrt{x^2 + y^2}", "r_1 - sqrt(x**2 + y**2)"),
    (
        r"l_1\,\dot\theta_1\sin\theta_1 + l_2\dot\theta_2\sin\theta_2 = 0",
        "l_1*theta_1_dot*sin(theta_1) + l_2*theta_2_dot*sin(theta_2)",
    ),
    (
        r"\omega_2 = \omega_1 \frac{l_1\sin(\theta_1-\beta)}{l_2\sin(\theta_2-\beta)}",
        "omega_2 - omega_1*l_1*sin(theta_1 - beta)/(l_2*sin(theta_2 - beta))",
    ),
    (r"\frac{\omega_1}{\omega_2} = \frac{z_2}{z_1}", "omega_1/omega_2 - z_2/z_1"),
    (r"s = R\theta - r\sin 2\theta", "s - R*theta + r*sin(2*theta)"),
    (r"x = r \cos \omega t", "x - r*cos(omega*time)"),
    (r"x = r\sin\theta\cos\phi", "x - r*sin(theta)*cos(phi)"),
    (r"h = l\sin^2\theta + l\cos^{2}\theta", "h - l*sin(theta)**2 - l*cos(theta)**2"),
    (r"a = -r\omega^2\cos\theta\left(1+\frac{r}{l}\right)", "a + r*omega**2*cos(theta)*(1 + r/l)"),
    (r"p = p_0\left(\frac{h}{h+s}\right)^{\kappa}", "p - p_0*(h/(h+s))**kappa"),
    (r"F = k\left(l-l_1\right)+c\,\dot s", "F - k*(l-l_1) - c*s_dot"),
    (r"P = F e^{\mu\theta}", None),
    (r"P = F \exp(\mu\theta)", "P - F*exp(mu*theta)"),
    (r"L = K - V", "L - K + V"),
    (r"\left|x\right| = r", "Abs(x) - r"),
    (
        r"(m_1+m_2) l_1^2\ddot\theta_1 + m_2 l_1 l_2\ddot\theta_2\cos(\theta_1-\theta_2) = "
        r"-(m_1+m_2)gl_1\sin\theta_1",
        "(m_1+m_2)*l_1**2*theta_1_ddot + m_2*l_1*l_2*theta_2_ddot*cos(theta_1-theta_2) + "
        "(m_1+m_2)*g*l_1*sin(theta_1)",
    ),
    (r"x = l_1c_1 + l_2c_2", "x - l_1*cos(theta_1) - l_2*cos(theta_2)"),
    (r"x_B = x_1 + l\cos(\theta + \pi/2)", "x_B - x_1 - l*cos(theta + pi/2)"),
    (r"\phi = 30^\circ", "phi - pi/6"),
    (r"\theta'' = 0", None),
    (r"v(t) = \frac{\mathrm{d}s}{\mathrm{d}t}", None),
    (
        r"F_x = \begin{cases} k x & \text{if } x > 0 \\ 0 & \text{otherwise}\end{cases}",
        "F_x - Piecewise((k*x, x > 0), (0, True))",
    ),
    (r"l_1^2 + l^2_2 = r^2", "l_1**2 + l_2**2 - r**2"),
    (r"s = 2r(1-\cos\tfrac{\theta}{2})", "s - 2*r*(1-cos(theta/2))"),
    (r"J\ddot\theta = T - \frac{F r}{2}\sin 2\theta,", "J*theta_ddot - T + F*r*sin(2*theta)/2"),
    (r"F_x = m(g + a) - 3\times 2 F_y", "F_x - m*(g+a) + 6*F_y"),
    (r"v_x = \dot x \cos\phi - \dot y\sin\phi", "v_x - x_dot*cos(phi) + y_dot*sin(phi)"),
    (r"x = \cos\theta\, r - \sin\theta \, l", "x - r*cos(theta) + l*sin(theta)"),
    (r"y = -\left[ r \sin\theta - \left( e + d \right) \right]", "y + r*sin(theta) - e - d"),
    (r"x = \\ \nonumber = r", "x - r"),
    (
        r"i = \frac{\omega}{\omega_1} = -\frac{z_1}{z_2}",
        "i - omega/omega_1; omega/omega_1 + z_1/z_2",
    ),
    (r"l = \sum_{i=1}^{2} l_i", "l - l_1 - l_2"),
    (
        r"x = l + 2\sum\limits_{j=1}^2 l_j\cos\theta_j - r",
        "x - l - 2*(l_1*cos(theta_1) + l_2*cos(theta_2)) + r",
    ),
    (r"M = \sum_{i=1}^{2} (m_i + m) + m_1", "M - 2*m - 2*m_1 - m_2"),
    (r"l = \sum_{i=1}^{2} i r", "l - 3*r"),
    (r"F_{x} = \sum_{x=1}^{1} F_{\mathrm{12x}} \frac{x}{2}", "F_x - F_12x/2"),
    (r"x = r = l \approx s", "x - r; r - l"),
    (r"x = \underbrace{r\theta}_{\text{arc}} + \overbrace{l + s}^{h}", "x - r*theta - l - s"),
    (r"x = l {(r + s)}/h", "x - l*(r + s)/h"),
    ("x = r + l = \\\\\n = s", "x - r - l; r + l - s"),
]


@pytest.mark.parametrize("case", TYPICAL, ids=[case[0][:40] for case in TYPICAL])
def test_typical_equation_has_its_meaning(case):
    latex, expected, *table = case
    if expected is None:
        with pytest.raises(FormulaError):
            read(latex, *table)
        return
    assert len(TYPICAL) >= 40
    expected_residuals = [sp.sympify(part, locals=dict(Q)) for part in expected.split(";")]
    assert [
        sp.simplify(a - b) for a, b in zip(read(latex, *table), expected_residuals, strict=True)
    ] == [0] * len(expected_residuals)


def test_matrices_are_compared_entry_by_entry():
    latex = (
        r"\begin{bmatrix} x \\ y \end{bmatrix} = \begin{pmatrix} \cos\theta & -\sin\theta \\ "
        r"\sin\theta & \cos\theta \end{pmatrix} \begin{bmatrix} l \\ e \end{bmatrix}"
    )
    c, s = sp.cos(Q.theta), sp.sin(Q.theta)
    assert read(latex) == [Q.x - (c * Q.l - s * Q.e), Q.y - (s * Q.l + c * Q.e)]


def test_transposed_row_is_a_column():
    assert read(
        r"[x] = \begin{bmatrix} l & e \end{bmatrix}\begin{bmatrix} 1 & 0\end{bmatrix}^T"
    ) == [Q.x - Q.l]


def test_determinant_is_multiplied_out():
    assert read(r"\begin{vmatrix} x & y \\ l & r \end{vmatrix} = 0") == [Q.x * Q.r - Q.y * Q.l]


def test_macros_with_arguments_are_expanded():
    macros = build_document(
        "a.tex", ".tex", r"\newcommand{\half}[1]{\frac{#1}{2}} \def\th{\theta}"
    ).macros
    assert read(r"x = \half{r}\cos\th", macros=macros) == [Q.x - Q.r * sp.cos(Q.theta) / 2]


def test_letters_above_a_name_are_its_own_where_a_table_says_so():
    assert read(r"J^{lr} = m r^2", {"J^{lr}": "J"}) == [Q.J - Q.m * Q.r**2]
    assert read(r"J^{lr} = m r^2") == [Q.J ** (Q.l * Q.r) - Q.m * Q.r**2]
    assert read(r"x^{n} = r", {"x^{m}": "x"}) == [Q.x**Q.n - Q.r]


def test_units_decide_the_argument_of_a_function():
    assert read(r"h = \sin\theta l") == [Q.h - Q.l * sp.sin(Q.theta)]
    assert read(r"h = l\cos\omega t_1") == [Q.h - Q.l * sp.cos(Q.omega * Q.t_1)]


def test_units_decide_what_a_slash_divides():
    assert read(r"\omega = v/r") == [Q.omega - Q.v / Q.r]
    assert read(r"M_1 = F_x/l r^2") == [Q.M_1 - Q.F_x / Q.l * Q.r**2]
    assert read(r"\theta = x y/l r") == [Q.theta - Q.x * Q.y / (Q.l * Q.r)]


REFUSED = [
    r"x = r\cos\theta + ",
    r"x = (r + l",
    r"x = r + l)",
    r"x = \unknown{r}",
    r"x = r_9",
    r"x = \pm\sqrt{r^2}",
    r"s = \int_0^1 v\,dt",
    r"F = \sum_{i=1}^{3} F_i",
    r"F = \sum_{i=1}^{n} F_i",
    r"F = \sum_{i} F_i",
    r"F = \sum_{i=2}^{1} F_i",
    r"l = \sum_{i=1}^{2} r",
    r"l = \sum_{i=1}^{2} l_i + r_i",
    r"x = l {r + s}",
    r"x = l - {r + s}",
    r"x^2 = {r l}^2",
    r"x^2 = {r + l}^2",
    r"x = \left. r \right|_{\theta=0}",
    r"x = 0,5 r",
    r"x = r!",
    r"x + r",
    r"x = \vec{r}\,\vec{l}",
    r"\dot{x + y} = v",
    r"x = \begin{bmatrix} l \\ e \end{bmatrix}",
    r"x = \begin{bmatrix} l & e \\ r \end{bmatrix}",
    r"\theta = \alpha/n \mu",
    r"x(0) = r",
    r"x = r \text{ if it turns}",
    r"x = \lim_{t} r",
    r"x \to r",
    r"x = = r",
    r"\boxed{x = r",
    r"x = r - \underbrace{e - d}_{\text{small}} + l",
    r"x = \sqrt[n]{r}",
    r"x = r''",
    r"v = \frac{\partial x}{\partial y \partial s}",
]


@pytest.mark.parametrize("latex", REFUSED)
def test_uncertain_formula_is_refused(latex):
    with pytest.raises((FormulaError, OperandError)):
        read(latex)


def test_sum_goes_over_its_own_bounds():
    """The nearest wrong reading, of one term more or less, is another equation."""
    right, *wrong = (
        read(rf"\omega_{{1}} = \sum_{{i={first}}}^{{{last}}} \omega_i")
        for first, last in ((1, 2), (1, 1), (2, 2))
    )
    assert right == [-Q.omega_2]
    assert all(other != right for other in wrong)


def test_approximation_states_nothing_to_judge():
    assert read(r"\sin\theta \approx \theta") == read(r"\sin\theta \approx r") == []


def test_inverse_of_a_matrix_is_read():
    matrix = r"\begin{bmatrix} l & e \\ 0 & r \end{bmatrix}"
    unknown, column = (
        r"\begin{bmatrix} \theta_1 \\ \theta_2 \end{bmatrix}",
        r"\begin{bmatrix} x \\ y \end{bmatrix}",
    )
    inverse = sp.Matrix([[Q.l, Q.e], [0, Q.r]]).inv() * sp.Matrix([Q.x, Q.y])
    for power in ("^{-1}", "^{ -1 }"):
        residuals = read(f"{unknown} = \\left({matrix}\\right){power} {column}")
        assert [sp.simplify(a) for a in residuals] == [
            sp.simplify(Q.theta_1 - inverse[0]),
            sp.simplify(Q.theta_2 - inverse[1]),
        ]
    transposed = read(
        f"{unknown} = \\left({matrix}\\right)^T {column}".replace("= ", r"= \frac{1}{l r}")
    )
    assert sp.simplify(transposed[1] - residuals[1]) != 0


def test_inverse_of_three_rows_is_that_of_sympy():
    rows = [[Q.l, Q.e, Q.x], [Q.y, Q.r, Q.s], [Q.d, Q.h, Q.R]]
    value = MatrixValue(tuple(tuple(to_scalar(entry) for entry in row) for row in rows)).inverse()
    assert sp.simplify(
        sp.Matrix(3, 3, [e.value for e in value.entries]) * sp.Matrix(rows)
    ) == sp.eye(3)
    assert {entry.dimension for entry in value.entries} == {to_scalar(1 / Q.l).dimension}
    singular = MatrixValue(((to_scalar(Q.l), to_scalar(Q.e)), (to_scalar(Q.l), to_scalar(Q.e))))
    with pytest.raises(OperandError, match="singular"):
        singular.inverse()


@pytest.mark.parametrize("space", ["", " ", r"\,", r" \, "])
def test_units_decide_what_a_name_before_brackets_is(space):
    assert read(rf"V{space}(x) = L") == [Q.V - Q.L]
    assert read(rf"M_1 = F{space}(x)") == [Q.M_1 - Q.F * Q.x]
    with pytest.raises(FormulaError):
        read(rf"F_x = F{space}(\theta)")


def test_refusal_names_the_place():
    with pytest.raises(FormulaError, match="sum") as refused:
        read(r"x = r + \sum_{i} l_i")
    assert ">>>" in str(refused.value)


def test_e_is_the_base_of_exponentials_unless_it_is_a_name():
    bare = {name: quantity for name, quantity in Q.items() if name != "e"}
    names = StatedNames(Formulas("names", given=Q), bare, NameTable())
    ((_, _, left, right),) = interpret_formula(
        read_formula(r"P = F e^{-\mu\theta}"), names
    ).residuals(names)
    assert left.value - right.value == Q.P - Q.F * sp.exp(-Q.mu * Q.theta)


def test_one_name_has_one_spelling():
    assert (
        spell_name(r"\dot\theta_1")
        == spell_name(r"\dot{\theta_{1}}")
        == spell_name(r"\dot{\theta}_1")
    )
    assert (
        spell_name(r"{}^N\omega^C")
        == spell_name(r"{}^{N}\omega^{C}")
        == spell_name(r"^N\omega^{C}")
    )
    assert spell_name(r"{}^N\bar{\omega}^C") == spell_name(r"^N\bar\omega^{C}")
    assert spell_name(r"F_{\mathrm{in}}") == spell_name(r"F_{in}") == spell_name(r"F_{\rm in}")
    assert len({spell_name(name) for name in (r"\mathbf{x}", "x", "x'", r"\hat{x}")}) == 4


@pytest.mark.parametrize(
    ("latex", "same"),
    [
        (r"y = gcos{\theta} + vtan(\delta)", r"y = g\cos\theta + v\tan\delta"),
        (r"y = mcos^2{\theta} - sin\theta", r"y = m\cos^2\theta - \sin\theta"),
        (r"y = \arctan2(a, b)", r"y = \operatorname{atan2}(a, b)"),
    ],
)
def test_functions_without_backslash_are_read(latex: str, same: str) -> None:
    functions = [
        [
            (node.function, len(node.arguments))
            for node in list_nodes(read_formula(text))
            if isinstance(node, FunctionCall)
        ]
        for text in (latex, same)
    ]
    assert [name for name, _ in functions[0]] == [name for name, _ in functions[1]] != []


@pytest.mark.parametrize("latex", [r"y = c o s (x)", r"y = a_{cos} (x)", r"y = \arctan 2 (x)"])
def test_letters_that_are_no_function_stay(latex: str) -> None:
    functions = {
        node.function for node in list_nodes(read_formula(latex)) if isinstance(node, FunctionCall)
    }
    assert functions <= {"atan"}


def test_brackets_read_before_are_the_same() -> None:
    """Whatever was read before, a formula is the same but for the places of its brackets."""
    brackets: dict[tuple[str, ...], Bracket] = {}
    texts = (
        r"a (b + c (d - e)) = f [g (b + c)]",
        r"x = (d - e) + a (b - c (d - e))",
        r"\frac{(b + c)}{2} = (b, c)",
    )
    for text in texts:
        formulas = read_formula(text), read_formula(text, None, brackets)
        first, second = (re.sub(r"start=\d+, end=\d+", "", repr(formula)) for formula in formulas)
        assert first == second
    assert any(key[:5] == ("(", "d", "-", "e", ")") for key in brackets)


@pytest.mark.parametrize(
    "texts", [(r"a (q (t) + b)", r"a (q(t) + b)"), (r"a (q(t) + b)", r"a (q (t) + b)")]
)
def test_bracket_of_other_spaces_is_read_anew(texts: tuple[str, str]) -> None:
    brackets: dict[tuple[str, ...], Bracket] = {}
    read_formula(f"x = {texts[0]}", None, brackets)
    second, alone = read_formula(f"x = {texts[1]}", None, brackets), read_formula(f"x = {texts[1]}")
    assert re.sub(r"start=\d+, end=\d+", "", repr(second)) == re.sub(
        r"start=\d+, end=\d+", "", repr(alone)
    )


def test_comma_between_digits_fails_after_spaced_one() -> None:
    brackets: dict[tuple[str, ...], Bracket] = {}
    read_formula("x = f (1, 2)", None, brackets)
    with pytest.raises(FormulaError):
        read_formula("x = f (1,2)", None, brackets)
