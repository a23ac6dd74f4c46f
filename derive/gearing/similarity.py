"""What of a pitch curve's contact does not change when all its lengths grow alike."""

from __future__ import annotations

import sympy as sp
from sympy import Expr

from ..quantity import Quantity
from . import meshing
from .pitch_curve import PitchCurve, a, u

LENGTH = "m"


def lengths(curve: PitchCurve) -> tuple[Quantity, ...]:
    """The parameters that are lengths."""
    return tuple(p for p in curve.parameters if p.unit == LENGTH)


def unchanged(curve: PitchCurve) -> tuple[Quantity, ...]:
    """Ratio, its slope and the rotation where they are the same for similar curves; none where that is not proved.

    A function of lengths that is homogeneous of degree 0 satisfies Euler's identity. Closure and series are means of
    the ratio over u, so that for similar curves the centre distance grows with the lengths, and the series is the same.
    """
    ratio, distance, turned = curve.ratio(), curve.centre_distance(), curve.turned()
    known = [ratio, ratio.diff(u), *([turned] if isinstance(turned, Expr) else [])]
    alike = all(_degree(curve, f, 0) for f in known)
    grows = _degree(curve, distance, 1) if isinstance(distance, Expr) else True
    return (meshing.ratio, meshing.dratio, meshing.turned) if alike and grows else ()


def _degree(curve: PitchCurve, f: Expr, degree: int) -> bool:
    """Whether a function of the lengths and the centre distance is homogeneous of some degree, by Euler's identity."""
    grown = sum((length * f.diff(length) for length in (*lengths(curve), a)), sp.S.Zero)
    return bool(sp.simplify(grown - degree * f) == 0)
