"""Texts compared with a mechanism: what the names file may say, and errors in the files."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from derive.audit.terms import holds
from derive.audit.texts.trial import format_skeleton, read_trial
from derive.generated_folder import OwnError
from derive.mechanics.statement import MechanismError
from tests.support import own
from tests.support.made_up import read_text, record_equation

TEXT = r"""\begin{align}
 s &= r\cos\varphi + l\cos\beta \label{eq:s}\\
 T &= \frac{1}{2} m_s \dot{s}^2
\end{align}"""


@pytest.mark.parametrize(
    ("file", "content", "words"),
    [
        ("names.toml", "[names]\n'T' = 3\n", ("names.T", "text")),
        ("names.toml", "[names]\n'T' = \"kinetc()\"\n", ("names.T", "kinetc")),
        ("names.toml", "[names]\n'T' = \"__import__('os')\"\n", ("names.T", "__import__")),
        ("names.toml", "[names]\n'T = ' = \"r\"\n", ("T = ", "no name")),
        ("names.toml", "[nmes]\n'T' = \"r\"\n", ("nmes",)),
        ("names.toml", '[rows.99]\nskip = "no"\n', ("rows.99", "eq:s")),
        (
            "names.toml",
            "[rows.'eq:s']\nclaims = \"what F_gs is\"\n",
            ("rows.eq:s.claims", "what F_gas is"),
        ),
        ("names.toml", "[rows.1]\nnames = { T = 3 }\n", ("rows.1.names", "quotes")),
        ("names.toml", "until_s = -1\n", ("until_s", "positive")),
        ("names.toml", "[names\n", ("names.toml",)),
        ("slider_crank.py", "1 + \n", ("slider_crank.py",)),
        ("slider_crank.py", "x = 1\n", ("slider_crank.py", "Mechanism")),
        ("crank.tex", "\xff", ("crank.tex", "UTF-8")),
        ("crank.ipynb", "{", ("crank.ipynb", "notebook")),
        ("crank.pdf", "%PDF", ("crank.pdf", ".tex")),
    ],
)
def test_error_names_file_and_key(
    tmp_path: Path, file: str, content: str, words: tuple[str, ...]
) -> None:
    shutil.copy(own.EXAMPLES / "slider_crank.py", tmp_path)
    (tmp_path / "crank.tex").write_text(TEXT, encoding="utf-8")
    (tmp_path / "names.toml").write_text("", encoding="utf-8")
    (tmp_path / file).write_bytes(content.encode("latin-1"))
    text = file if file.startswith("crank.") else "crank.tex"
    with pytest.raises(OwnError) as refused:
        read_trial(tmp_path / text, tmp_path / "slider_crank.py", tmp_path / "names.toml")
    for word in words:
        assert word in str(refused.value)
    assert "\n" not in str(refused.value)


FRAMES = """
from derive import Mechanism, quantities

q = quantities("l | m | arm | 0.4\\nm_1 | kg | mass | 2\\nT_1 | s | period | 1\\nT_2 | s | period | 3")
m = Mechanism("arm", q)
alpha = m.coordinate("alpha", "rad", "turn")
N, A = m.world, m.frame("A", alpha)
P = m.point("P", m.O, A, q.l)
L = m.name_("L", "N m", "moment", q.l * q.m_1 * m.motion.acceleration(P, A)[1])
"""
VECTORS = r"""\begin{align}
 ^N\omega^A &= \dot\alpha \hat{a}_3 \label{spin}\\
 L &= (\bar{r} \times m_1\,\bar{a}) \cdot \hat{a}_3 \label{cross}\\
 \frac{{}^Nd\bar{r}}{dt} &= \frac{{}^Ad\bar{r}}{dt} + {}^N\omega^A \times \bar{r} \label{seen}\\
 \frac{{}^{\mathbf{N}} d \bar{r}}{dt} &= \frac{{}^\mathbf{A} d \bar{r}}{dt} + {}^N\omega^A \times \bar{r} \label{bold}\\
 T &= T_1 \label{first}\\
 T &= T_2 \label{second}
\end{align}"""
VECTOR_NAMES = """
[names]
'^N\\omega^A' = "spin(A)"
'\\hat{a}_3' = "axis(A, 3)"
'\\bar{r}' = "position(P)"
'\\bar{a}' = "acceleration(P)"
'T' = "T_1"
[rows.second]
names = { 'T' = "T_2" }
"""


def test_frames_products_and_names_of_a_row_have_their_meaning(tmp_path: Path) -> None:
    case = read_text(tmp_path, FRAMES, VECTORS, VECTOR_NAMES)
    assert [row.reason for row in case.source.rows] == [""] * 6
    for number, equation in case.paper.equations.items():
        assert equation.residual == 0 or record_equation(case, number)["verdict"] == "confirmed", (
            number
        )


TWICE = r"{}^{N}\omega^{A} \times ({}^{N}\omega^{A} \times \bar{r})"


@pytest.mark.parametrize(
    ("printed", "extra", "corrected"),
    [
        (rf"\bar{{a}} = {TWICE}", r"\epsilon", rf"{TWICE} + \epsilon \times \bar{{r}}"),
        (rf"\bar{{a}} = {TWICE}", "", None),
        (
            r"\bar{a} = \epsilon \times \bar{r}",
            r"\epsilon",
            r"\epsilon \times \bar{r} - \dot{\alpha}^2 \bar{r}",
        ),
        (r"\bar{v} = \bar{b}", r"\hat{a}_3", r"\bar{b} + \frac{3}{2} \dot{\alpha} l \hat{a}_{3}"),
        (r"\bar{v} = \bar{b}", r"", None),
    ],
)
def test_lost_vector_is_found(
    tmp_path: Path, printed: str, extra: str, corrected: str | None
) -> None:
    """A term with a vector of the names file is put back, of one vector or of products of two."""
    meanings = {
        r"\epsilon": "spin_rate(A)",
        r"{}^{N}\omega^{A}": "spin(A)",
        r"\hat{a}_3": "axis(A, 3)",
        r"\bar{r}": "position(P)",
        r"\bar{v}": "velocity(P)",
        r"\bar{a}": "acceleration(P)",
        r"\bar{b}": "vector(A, 0, l*alpha_dot, -1.5*l*alpha_dot)",
    }
    entries = [
        f"'{name}' = \"{text}\""
        for name, text in meanings.items()
        if name in extra or name in printed
    ]
    text = rf"\[ {printed} \] \[ l = \dot{{\alpha}} \]"
    case = read_text(tmp_path, FRAMES, text, "\n".join(["[names]", *entries]))
    wrong = (
        name
        for name, equation in case.paper.equations.items()
        if not holds(equation.residual, case.points)
    )
    repair = case.source.repair(next(wrong), case.points, case.draw)
    if corrected is None:
        assert repair is None
    else:
        assert repair is not None
        assert "".join(corrected.split()) in "".join(repair.latex.split())


GUIDED = """
from sympy import cos, sin
from derive import Mechanism, quantities

q = quantities('''
    g   | m/s2  | free fall                | 9.81
    L   | m     | rod                      | 0.4
    m   | kg    | mass of the rod          | 1.2
    J   | kg m2 | rod about its centroid   | 0.016
    k   | N/m   | spring at the lower end  | 200
    M_1 | kg    | mass of the upper block  | 0.5
''')
m = Mechanism("trammel", q, gravity=q.g)
theta = m.coordinate("theta", "rad", "angle of the rod")
m.begin({theta: 0.7})
A, B = (m.point(name, m.O, m.world, *place) for name, place in (
    ("A", (0, q.L * sin(theta))), ("B", (q.L * cos(theta), 0)),
))
G = m.point("G", m.O, m.world, q.L * cos(theta) / 2, q.L * sin(theta) / 2)
rod = m.body("rod", m.frame("rod", -theta), q.m, G, q.J)
m.pin("A", rod, m.body("block", m.world, q.M_1, A), A)
m.spring("spring", rod, m.ground, (B, m.O), q.k, 0)
"""
GUIDED_TEXT = r"""\begin{align}
 y_G &= \frac{L}{2}\sin\theta \\
 \dot y_G &= %s\frac{L}{2}\dot\theta\cos\theta \label{rate}\\
 \Bigl(J + \frac{m L^2}{4} + M_1 L^2\cos^2\theta\Bigr)\ddot\theta - M_1 L^2\dot\theta^2\sin\theta\cos\theta
 &= -\Bigl(\frac{m}{2} + M_1\Bigr) g L\cos\theta + k L^2\sin\theta%s \label{motion}\\
 F_{Ax} &= 0 \label{force}
\end{align}"""


@pytest.mark.parametrize("named", [False, True], ids=["without names", "with the skeleton"])
@pytest.mark.parametrize(
    ("sign", "factor", "verdict"), [("", r"\cos\theta", "confirmed"), ("-", "", "misprint")]
)
def test_motion_of_guided_bodies_is_judged_by_virtual_power(
    tmp_path: Path, sign: str, factor: str, verdict: str, named: bool
) -> None:
    """Nothing states the guides of a trammel's rod: Lagrange's equation is judged, and no force of
    a joint.
    """
    text = GUIDED_TEXT % (sign, factor)
    case = read_text(tmp_path, GUIDED, text)
    if named:
        case = read_text(tmp_path, GUIDED, text, format_skeleton(case))
    assert [record_equation(case, number)["verdict"] for number in ("rate", "motion")] == [
        verdict
    ] * 2
    assert "F_{Ax}" in case.source.explain_unjudged("force")


SHAKEN = """
from sympy import cos
from derive import Mechanism, quantities

q = quantities("U | m | stroke | 0.1\\nw | rad/s | pulsation | 3\\nM | kg | mass | 2")
m = Mechanism("shaken", q)
x = m.coordinate("x", "m", "place of the mass")
u = m.name_("u", "m", "place of the table", q.U * cos(q.w * m.time))
mass = m.body("mass", m.world, q.M, m.point("P", m.O, m.world, x, 0))
m.slide("rail", mass, m.ground, m.O)
"""


@pytest.mark.parametrize(("factor", "verdict"), [("", "confirmed"), ("2", "misprint")])
def test_functions_of_time_are_judged_after_the_start(
    tmp_path: Path, factor: str, verdict: str
) -> None:
    """At time zero any factor of the time would do."""
    text = rf"\begin{{equation}} u^2(t) = U^2 \cos^2({factor} w t) \label{{table}} \end{{equation}}"
    case = read_text(tmp_path, SHAKEN, text)
    assert record_equation(case, "table")["verdict"] == verdict


SLIDING = """
from sympy import sqrt
from derive import Mechanism, quantities

q = quantities("m | kg | mass | 2\\nR | N | drag | 3")
m = Mechanism("sliding", q)
x, y = m.coordinate("x", "m", "across"), m.coordinate("y", "m", "along")
P = m.point("P", m.O, m.world, x, y)
stone = m.body("stone", m.world, q.m, P)
speed = m.report("v", "m/s", "speed", sqrt(m.rate(x) ** 2 + m.rate(y) ** 2))
m.force("drag", stone, P, m.vector(m.world, -q.R * m.rate(x) / speed, -q.R * m.rate(y) / speed))
"""


@pytest.mark.parametrize("begin", ["", "m.begin({m.rate(x): 20})\n"])
def test_start_without_a_motion_is_an_error_that_names_the_remedy(
    tmp_path: Path, begin: str
) -> None:
    case = read_text(tmp_path, SLIDING + begin, r"\[ m \ddot{x} = -R \frac{\dot{x}}{v} \]")
    if begin:
        assert len(case.cycle) > 1
    else:
        with pytest.raises(MechanismError, match=r"divided by zero.*begin"):
            assert case.cycle
