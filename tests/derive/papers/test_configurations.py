"""Frames and points without bodies as what a text is compared with: random configurations that
close the loops.
"""

from __future__ import annotations

import random
from types import ModuleType

import pytest
from mpmath import mpf
from sympy import cos

from derive import Mechanism, quantities
from derive.audit.texts.documents import build_document
from derive.audit.texts.names import NameTable, spell_name
from derive.audit.texts.trial import build_trial
from derive.audit.user_mechanism.motions import ConfigurationSubject
from derive.audit.user_mechanism.trial import build_subject
from derive.evaluate import DIGITS, Point
from derive.mechanics.statement import MechanismError
from tests.support.made_up import record_equation

DATA = """
    a | m | crank   | 0.1
    b | m | coupler | 0.3
    c | m | rocker  | 0.25
    d | m | frame   | 0.35
"""


def four_bar(*, start: bool = True) -> ModuleType:
    """Return a module with a four-bar linkage of frames and points alone; its three angles are
    coordinates.
    """
    q = quantities(DATA)
    m = Mechanism("four_bar", q)
    theta_1, theta_2, theta_3 = (
        m.coordinate(name, "rad", "angle") for name in ("theta_1", "theta_2", "theta_3")
    )
    crank, coupler, rocker = (
        m.frame(name, angle) for name, angle in (("L", theta_1), ("M", theta_2), ("R", theta_3))
    )
    pin = m.point("B", m.point("A", m.O, crank, q.a), coupler, q.b)
    m.close(
        pin,
        m.point("C", m.point("D", m.O, m.world, q.d), rocker, q.c),
        start={theta_2: 0.8, theta_3: 1.5} if start else {},
    )
    module = ModuleType("linkage")
    module.m, module.B = m, pin
    return module


@pytest.fixture(scope="module")
def subject() -> ConfigurationSubject:
    return ConfigurationSubject(four_bar().m)


def test_rates_and_accelerations_keep_the_loop_closed(subject: ConfigurationSubject) -> None:
    gaps = list(subject.mechanism.loops.gaps.values())
    for seed in range(3):
        values = subject.admissible(random.Random(seed))
        largest = {}
        for step in (mpf("1e-4"), mpf("1e-5")):
            moved = dict(values)
            for c in subject.mechanism.loops.coordinates:
                moved[c.value] += values[c.rate] * step + values[c.acceleration] * step**2 / 2
            largest[step] = max(abs(Point(moved)(gap)) for gap in gaps)
        assert max(abs(Point(values)(gap)) for gap in gaps) < mpf(10) ** -DIGITS
        assert largest[mpf("1e-5")] == pytest.approx(largest[mpf("1e-4")] / 1000, rel=0.01)


def test_text_of_kinematics_alone_is_judged_without_bodies() -> None:
    module = four_bar()
    assert isinstance(build_subject(module.m), ConfigurationSubject)
    text = r"""\begin{align}
    a\cos\theta_1 + b\cos\theta_2 &= d + c\cos\theta_3 \tag{1}\\
    a\dot\theta_1\cos\theta_1 + b\dot\theta_2\cos\theta_2 &= c\dot\theta_3\cos\theta_3 \tag{2}\\
    \dot\theta_3 &= \dot\theta_1\frac{a\sin(\theta_1 + \theta_2)}{c\sin(\theta_3-\theta_2)} \tag{3}\\
    a\ddot\theta_1\sin\theta_1 + a\dot\theta_1^2\cos\theta_1 + b\ddot\theta_2\sin\theta_2 + b\dot\theta_2^2\cos\theta_2
      &= c\ddot\theta_3\sin\theta_3 + c\dot\theta_3^2\cos\theta_3 \tag{4}\\
    v &= a\dot\theta_1\cos\theta_1 + b\dot\theta_2\cos\theta_2 \tag{5}
    \end{align}"""
    meaning = "component(cross(axis(world, 3), velocity(B)), 1)"
    table = NameTable({spell_name("v"): f"-{meaning}"})
    case = build_trial(build_document("linkage.tex", ".tex", text), module.m, table, module)
    records = {
        record["equation"]: record
        for number in case.paper.equations
        for record in [record_equation(case, number)]
    }
    verdicts = {number: record["verdict"] for number, record in records.items()}
    assert verdicts == {
        "1": "confirmed",
        "2": "confirmed",
        "3": "misprint",
        "4": "confirmed",
        "5": "confirmed",
    }
    assert r"\theta_1 - \theta_2" in records["3"]["corrected_latex"]


def test_loop_without_a_start_is_refused() -> None:
    with pytest.raises(MechanismError, match="start"):
        ConfigurationSubject(four_bar(start=False).m)


def test_lengths_that_never_close_are_refused() -> None:
    q = quantities(DATA.replace("0.25", "0.01"))
    m = Mechanism("apart", q)
    coupler_angle, rocker_angle = (
        m.coordinate("theta_2", "rad", "angle"),
        m.coordinate("theta_3", "rad", "angle"),
    )
    crank_end = m.point("B", m.O, m.frame("M", coupler_angle), q.c)
    rocker_end = m.point("C", m.point("D", m.O, m.world, q.d), m.frame("R", rocker_angle), q.c)
    m.close(crank_end, rocker_end, start={coupler_angle: 0.5, rocker_angle: 0.5})
    subject = ConfigurationSubject(m)
    with pytest.raises(MechanismError):
        subject.admissible(random.Random(1))


def test_rates_and_accelerations_satisfy_rolling_without_slip() -> None:
    m = Mechanism("disc", quantities("r | m | radius | 0.3"), spatial=True)
    q = m.given
    x, roll, yaw = (
        m.coordinate(name, unit, name)
        for name, unit in (("x", "m"), ("roll", "rad"), ("yaw", "rad"))
    )
    drop = m.coordinate("drop", "m", "height")
    double = m.name_("double", "m", "diameter", 2 * q.r)
    m.constrain("plane", drop - double / 2, start={drop: q.r})
    m.roll("wheel", m.rate(x) - q.r * m.rate(roll) * cos(yaw))
    values = ConfigurationSubject(m).admissible(random.Random(1))
    rates = m.motion.rates
    accelerations = {c: rates[rates[c]] for c in (x, roll, drop)}
    at = Point(values)
    assert abs(at(rates[x] - q.r * rates[roll] * cos(yaw))) < 1e-30
    assert abs(at(m.rate(m.rate(x) - q.r * m.rate(roll) * cos(yaw)))) < 1e-30
    assert abs(at(rates[drop])) < 1e-30
    assert abs(at(accelerations[drop])) < 1e-30
    assert abs(at(rates[x])) > 1e-9
