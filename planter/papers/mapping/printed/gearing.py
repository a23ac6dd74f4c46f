"""The split of a ratio over two stages."""

from __future__ import annotations

from planter.audit.registry import Inputs, Value, formula
from planter.papers.mapping.curve import closed_turn
from planter.papers.mapping.train import Train


@formula("split of the ratio")
def split_parameter(inputs: Inputs) -> Value:
    """Parameter that closes the first of two stages of a ratio: the mean of its inverse root over a
    turn.

    None where the curve is not monotone. The centre distance has no part in it.
    """
    curve = closed_turn(inputs.si("carrier_deg")[:-1], inputs.si("relative_deg")[:-1])
    return Train(curve, distance=1.0).x_s if curve.monotone else None
