"""Turns that do not end in the state in which they began: what they tell, and what they must
not.
"""

from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import jsonschema
import numpy as np
import pytest

from planter.engine.machine import Machine
from planter.engine.measures import parse_measure
from planter.engine.search import SearchSpec
from planter.errors import ComputationError
from planter.mechanism import cam, optimisation, printed
from planter.mechanism.cycle import compute_cycle, list_lift_offs
from planter.mechanism.file import MechanismFile
from planter.mechanism.machines import build_machine
from planter.mechanism.model import Model
from planter.mechanism.presentation import present_cycle
from planter.mechanism.swept import ADAPTER
from tests.support.own import file
from tests.support.schemas import load_schema

BELT = '''
from sympy import Rational
from derive import Mechanism, quantities

q = quantities("""
    phi   | rad   | driver
    omega | r/min | speed of the driver   | 60
    g     | m/s2  | free fall             | 9.81
    e     | mm    | centroid              | 50  | 10 90
    m     | kg    | pulley                | 2
    J     | kg m2 | pulley                | 0.01
""")
m = Mechanism("belt", q, angle=q.phi, speed=q.omega, gravity=q.g)
chi = m.coordinate("chi", "rad", "pulley", equals=RATIO * q.phi)
frame = m.frame("pulley", chi)
pulley = m.body("pulley", frame, q.m, m.point("C", m.O, frame, q.e), q.J)
m.pin("O", pulley, m.ground, m.O)
m.motor("M_in", pulley, m.ground, m.O)
'''
CORD = 'm.report("cord", "m", "cord that the driver has wound", q.e * q.phi)\n'


def belt(ratio: Fraction, more: str = "") -> MechanismFile:
    text = BELT.replace("RATIO", f"Rational({ratio.numerator}, {ratio.denominator})")
    return file(f"{text}{more}SYSTEM = m.system()\n", "belt")


def belt_machine(ratio: Fraction, more: str = "") -> Machine:
    return build_machine(belt(ratio, more))


@pytest.mark.parametrize("ratio", [Fraction(1, 2), Fraction(-5, 4)])
def test_nonperiodic_quantities_are_reported(ratio: Fraction) -> None:
    result = compute_cycle(Model(belt_machine(ratio))).result
    jsonschema.validate(result.table(), load_schema("turn"))
    assert {"chi_deg", "M_in_Nm", "P_M_in_W", "F_Ox_N"} <= result.not_repeating.keys()
    assert not {"chi_dot_rad_s", "chi_ddot_rad_s2"} & result.not_repeating.keys()
    assert result.repeats_after_turns == ratio.denominator
    assert result.work == {"M_in_J": None}
    assert (result.quantities["M_in_Nm"].mean, result.quantities["M_in_Nm"].rms) == (None, None)
    assert result.quantities["chi_dot_rad_s"].mean == pytest.approx(2 * np.pi * ratio)
    assert [(warning.name, "chi" in warning.message) for warning in result.warnings] == [
        ("does_not_repeat", True)
    ]


def test_turn_with_whole_ratio_repeats() -> None:
    """An angle that gains whole turns is no change; its mean is that of the turn, not that of 360
    samples of it.
    """
    result = compute_cycle(Model(belt_machine(Fraction(-2)))).result
    assert (result.not_repeating, result.repeats_after_turns, result.warnings) == ({}, 1, [])
    assert result.quantities["chi_deg"].mean == pytest.approx(-360.0, rel=1e-12)
    assert result.quantities["chi_deg"].rms == pytest.approx(720 / np.sqrt(3), rel=1e-4)
    assert result.work["M_in_J"] == pytest.approx(0, abs=1e-12)


def test_growing_length_is_reported() -> None:
    result = compute_cycle(Model(belt_machine(Fraction(1), CORD))).result
    assert result.not_repeating == {"cord_mm": pytest.approx(100 * np.pi)}
    assert result.repeats_after_turns is None
    assert result.work["M_in_J"] == pytest.approx(0, abs=1e-12)


def test_turn_whose_next_turn_fails_gives_no_means() -> None:
    """The square root ends at 400 deg."""
    more = (
        'from sympy import sqrt\nm.report("left", "1", "what is left", sqrt(Rational(7) - q.phi))\n'
    )
    result = compute_cycle(Model(belt_machine(Fraction(1), more))).result
    assert set(result.not_repeating.values()) == {None}
    assert result.work == {"M_in_J": None}
    assert "left" in result.warnings[0].message


def test_averages_of_nonperiodic_quantities_are_refused() -> None:
    source, half = belt(Fraction(1, 2), CORD), belt_machine(Fraction(1, 2), CORD)
    with pytest.raises(ComputationError, match="M_in"):
        printed.evaluate_measure(source, parse_measure("rms M_in", "a"), None, None)
    with pytest.raises(ComputationError, match="M_in"):
        optimisation.optimise_machine(half, "rms M_in", spec=SearchSpec(starts=1))
    with pytest.raises(ComputationError, match="cord"):
        cam.build_profile(Model(half), 0.001, "cord", "e")
    assert printed.evaluate_measure(
        source, parse_measure("max chi", "a"), None, None
    ) == pytest.approx(np.pi)
    assert printed.evaluate_measure(source, parse_measure("min chi", "a"), None, None) == 0
    names = ("M_in_mean_Nm", "M_in_max_Nm", "chi_dot_mean_rad_s")
    ends = {"values.e_mm": (50.0, 50.0)}
    rows = ADAPTER.subject(ADAPTER.frozen(source), {}, ends, names).evaluated(np.array([[50.0]]), 1)
    assert rows[0] == pytest.approx([np.nan, 0.981, np.pi], nan_ok=True)


def test_contact_of_nonperiodic_cycle() -> None:
    """A force that is negative at both ends of the turn is so in two stretches, none of which
    passes its end.
    """
    more = (
        "from sympy import sin\nN = m.report('N_c', 'N', 'contact', q.m * q.g * (sin(chi) - "
        "Rational(1, 2)))\n"
    )
    machine = belt_machine(Fraction(1, 2), more)
    pushing = tuple(
        replace(quantity, is_push=quantity.name == "N_c") for quantity in machine.quantities
    )
    model, angles = Model(replace(machine, quantities=pushing)), 2 * np.pi * np.arange(90) / 90
    lift_offs = list_lift_offs(model, angles, model(angles), repeats=False)
    assert [lift_off.phi_deg for lift_off in lift_offs] == pytest.approx([0.0, 300.0], abs=1e-6)


def test_curve_and_drawing_end_where_the_turn_does(tmp_path: Path) -> None:
    half = compute_cycle(Model(belt_machine(Fraction(1, 2))))
    assert not half.repeats
    assert half.ends["chi_deg"] == pytest.approx(180.0)
    present_cycle(half).write(tmp_path / "run")
    assert "does_not_repeat" in (tmp_path / "run" / "report.html").read_text(encoding="utf-8")
