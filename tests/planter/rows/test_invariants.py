"""Tolerances of machines with a single value, or none, that no angle changes."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.support import own
from tests.support.cli import answer

ISHIGAMI = '''
from sympy import sin
from derive import Formulas, quantities
q = quantities("""
    t   | rad   | dummy angle
    n   | rad/s | its speed | 1
    a   | rad   | first     | 0.5
    b   | rad   | second    | 0.5
    c   | rad   | third     | 0.5
    one | rad   | a radian  | 1
    y   | 1     | the function
""")
f = Formulas("ishigami", given=q, angle=q.t, speed=q.n)
f.defines(q.y, sin(q.a) + 7 * sin(q.b) ** 2 + (q.c / q.one) ** 4 * sin(q.a) / 10)
SYSTEM = f.system()
'''
RIGHT = {"a_rad": (0.3139, 0.5576), "b_rad": (0.4424, 0.4424), "c_rad": (0.0, 0.2437)}
"""First and total indices of Ishigami's function with 7 and 0.1 (Ishigami and Homma 1990, by their
closed forms).
"""
UNIFORM = '{ from = -3.141592653589793, to = 3.141592653589793, distribution = "uniform" }'


def test_indices_equal_closed_forms(tmp_path: Path) -> None:
    tolerances = tmp_path / "t.toml"
    tolerances.write_text("[tolerances]\n" + "".join(f"{name} = {UNIFORM}\n" for name in RIGHT))
    machine = str(own.generated(ISHIGAMI) / "ishigami.toml")
    options = (
        "--tolerances",
        str(tolerances),
        "--output",
        "max y",
        "--samples",
        "4000",
        "--indices",
        "4096",
    )
    result = answer("tolerance", machine, *options)
    (indices,) = result["sobol"].values()
    for name, (first, total) in RIGHT.items():
        row = indices[name if name in indices else f"values.{name}"]
        assert (row["first"], row["total"]) == pytest.approx((first, total), abs=0.03)
    (band,) = result["outputs"].values()
    assert band["std"] ** 2 == pytest.approx(13.8446, rel=0.03)
