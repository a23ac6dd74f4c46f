"""The output shaft in a bearing that clamps it, holds it elastically, or lets it turn."""

from __future__ import annotations

import pytest
import sympy as sp

from derive.papers.clutch import model as beam
from derive.papers.clutch import motion
from derive.papers.clutch import quantities as q

HELD = ("deflection at the bearing", "slope at the bearing")


@pytest.mark.parametrize("fixity", [sp.S.One, sp.Rational(3, 4), sp.Rational(1, 5)])
def test_deflections_of_beam_and_bearing_add_up(fixity: sp.Rational) -> None:
    """A cantilever gives way by l^3/(3 E I), a bearing of the stiffness k by l^2/k, with k = c E
    I/((1 - c) l).
    """
    _, stiffness = beam.shape_integrals(beam.static_shape(fixity))
    moment = beam.static_shape(fixity).diff(beam.Z, 2).subs(beam.Z, 0)
    turning = beam.static_shape(fixity).diff(beam.Z).subs(beam.Z, 0) * moment
    assert 1 / (stiffness + turning) == sp.Rational(1, 3) + (1 - fixity) / fixity


def test_a_hinged_beam_only_turns() -> None:
    assert beam.static_shape(sp.S.Zero) == beam.Z
    assert beam.shape_integrals(beam.static_shape(sp.S.Zero))[1] == 0


@pytest.mark.parametrize("fixity", [sp.S.Zero, sp.Rational(1, 2), sp.S.One])
def test_end_condition_follows_the_bearing(fixity: sp.Rational) -> None:
    """The static shape of a bearing meets its own end condition and no other; the sine meets the
    hinge's alone.
    """
    static = beam.static_shape(fixity).subs(beam.Z, q.x / q.l)
    for other in (sp.S.Zero, sp.Rational(1, 2), sp.S.One):
        left = {
            name: e.subs(q.fixity, other) for name, e in motion.bearing_conditions(static).items()
        }
        assert {name for name, e in left.items() if sp.simplify(e) != 0} == (
            {HELD[1]} if other != fixity else set()
        )
    left = {
        name: e.subs(q.fixity, fixity)
        for name, e in motion.bearing_conditions(motion.assumed_mode()).items()
    }
    assert {name for name, e in left.items() if e != 0} == ({HELD[1]} if fixity else set())
