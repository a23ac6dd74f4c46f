"""Laws of motions in which something vanishes truly: rounding breaks none, a slight error breaks
the right ones.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from planter.mechanism.cycle import compute_cycle
from planter.mechanism.machines import build_machine
from planter.mechanism.model import Model
from planter.mechanism.presentation import present_cycle
from tests.support import own
from tests.support.cli import answer

ROTOR = '''
from sympy import Rational, cos, sin
from derive import Mechanism, Paper, quantities, trial

q = quantities("""
    phi   | rad   | angle
    omega | r/min | speed                  | SPEED
    r     | mm    | centroid               | RADIUS
    m     | kg    | rotor                  | MASS
    J     | kg m2 | rotor, of no influence | 0.02
""")
m = Mechanism("rotor", q, angle=q.phi, speed=q.omega)
turned = m.frame("rotor", q.phi)
C = m.point("C", m.O, turned, q.r)
rotor = m.body("rotor", turned, q.m, C, q.J, about=C)
m.pin("O", rotor, m.ground, m.O)
m.motor("M_in", rotor, m.ground, m.O)
x, y, torque = m.assembly.unknowns
PAPER = Paper("p", "A rotor")
PAPER.equation("1", x + q.m * q.r * q.omega**2 * cos(q.phi), m.balance(rotor, "force", "x"))
PAPER.equation("2", y + q.m * q.r * q.omega**2 * sin(q.phi), m.balance(rotor, "force", "y"))
PAPER.equation("3", torque + q.r * sin(q.phi) * x - FACTOR * q.r * cos(q.phi) * y, m.balance(rotor, "moment"))
CASE = trial(m, PAPER)
'''


def audit_rotor(folder: Path, factor: str = "1", **values: str) -> dict[str, dict[str, object]]:
    """Return the laws by name; a rotor at constant speed needs no torque: that of its two forces is
    rounding.
    """
    text = ROTOR.replace("FACTOR", factor)
    for name, value in {"SPEED": "1200", "RADIUS": "70", "MASS": "3.1", **values}.items():
        text = text.replace(name, value)
    path = folder / "rotor.py"
    path.write_text(text, encoding="utf-8")
    laws: list[dict[str, object]] = answer("audit", str(path))["laws"]
    return {f"{law['law']}, {law['unit']}": law for law in laws}


@pytest.mark.parametrize(
    "values", [{}, {"MASS": "3e-6", "RADIUS": "0.2"}, {"SPEED": "90000", "MASS": "4e4"}]
)
def test_moment_that_is_rounding_breaks_no_law(tmp_path: Path, values: dict[str, str]) -> None:
    laws = audit_rotor(tmp_path, **values)
    assert len(laws) == 10
    assert all((law["violation"], law["owed"]) == (0, "") for law in laws.values())


@pytest.mark.parametrize("values", [{}, {"MASS": "3e-6", "RADIUS": "0.2"}])
def test_slight_error_beside_a_vanishing_moment_is_found(
    tmp_path: Path, values: dict[str, str]
) -> None:
    laws = audit_rotor(tmp_path, "Rational(100001, 100000)", **values)
    broken = {name for name, law in laws.items() if law["violation"]}
    assert "rate of angular momentum less outer moments, z, N m" in broken
    assert not any("force" in name and name.endswith(", N") for name in broken)
    assert all(laws[name]["caused_by"] == ["3"] for name in broken)


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_laws_of_a_cycle_hold_at_any_size_of_force(scale: float) -> None:
    masses = {
        "m_r_kg": 0.8 * scale,
        "m_s_kg": 1.5 * scale,
        "J_kg_m2": 0.004 * scale,
        "k_N_m": 900 * scale,
    }
    machine = build_machine(own.file("slider_crank", A_m2=0.002 * scale, **masses))
    cycle = compute_cycle(Model(machine))
    laws = [law for law in cycle.result.laws if law.unit in ("N", "N m", "W")]
    assert laws
    assert all(law.violation < 1e-10 * law.scale for law in laws)
    force = max(q.max for key, q in cycle.result.quantities.items() if key.endswith("_N"))
    assert next(law.scale for law in laws if law.unit == "N") >= force
    assert "laws hold" in present_cycle(cycle).conclusion
    tampered = replace(laws[0], violation=1e-6 * laws[0].scale)
    worse = replace(cycle, result=replace(cycle.result, laws=[tampered, *laws[1:]]))
    assert "laws hold" not in present_cycle(worse).conclusion
