"""The planting device: what is looked up of its derivation is there, or it is refused with a
sentence.
"""

import pytest

from derive.equations import Balance, ClaimError
from derive.papers.planting import claims, derivation
from derive.papers.planting import quantities as q


def test_mechanism_derives_unnamed_relations() -> None:
    relations = claims.derive_relations(derivation.build_device())
    assert {str(symbol) for symbol in relations} == {"M_Az", "M_Aoz", "F_A1z", "M_K", "M_P", "M_Q"}


def test_a_mechanism_without_a_balance_is_refused() -> None:
    device = derivation.build_device()
    device.assembly.bodies.pop()
    with pytest.raises(
        ClaimError,
        match="nothing here states 'outer half: moment along z of planet about A ou",
    ):
        claims.derive_relations(device)


def test_assumptions_are_lifted_from_balances_alone() -> None:
    assert claims.relax_balance(Balance("sun", "force", "x", "frame"), q.F_Px + q.F_Ox) is not None
    assert claims.relax_balance("moment of the cam force about the planet's axis", q.M_T) is None
