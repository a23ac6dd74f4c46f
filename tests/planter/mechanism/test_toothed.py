"""Gears of mechanisms of one's own: the pitch curves of their motion, closed, at the distance of
their axes.
"""

import numpy as np
import pytest
from scipy.special import ellipe

from planter.errors import InputError
from planter.mechanism.model import Model
from planter.mechanism.toothed import MechanismMesh
from tests.support import own

ROUND = """
from derive import Formulas, quantities

q = quantities('''
    t | rad   | driver        | 0.5 | 0 6
    n | r/min | its speed     | 60
    a | mm    | axes          | 60  | 50 70
    r | m     | driver, pitch radius
''')
gears = Formulas("own", given=q, angle=q.t, speed=q.n)
gears.defines(q.r, q.a / 3)
gears.mesh("P", ("driver", q.t, q.r), ("large wheel", -q.t / 2, q.a - {radius} * q.r))
SYSTEM = gears.system()
"""


def mesh(source: str, tag: str = "P", name: str = "") -> MechanismMesh:
    names = own.file(source, name).model.sidecar["meshes"][tag]
    return MechanismMesh(Model(own.machine(source, name)), tag, tuple(names))


@pytest.mark.parametrize(
    ("name", "tag"), [("elliptic_gears", "P"), ("planetary_train", "P"), ("planetary_train", "Q")]
)
def test_pitch_curves_are_the_ellipses_of_the_statement(name: str, tag: str) -> None:
    pair = mesh(name, tag).pair()
    perimeter = 4 * 0.021 * ellipe(0.14**2)
    np.testing.assert_allclose([curve.length for curve in pair.curves], perimeter, rtol=1e-9)
    assert pair.distance == pytest.approx(0.042, rel=1e-9)


def test_round_gears_have_the_ratio_of_their_turning() -> None:
    wheels = mesh(ROUND.format(radius=1), name="own")
    pair = wheels.pair()
    assert wheels.turns == 2
    assert wheels.names == ("driver", "large wheel")
    np.testing.assert_allclose(
        [c.length for c in pair.curves], 2 * np.pi * np.array([0.02, 0.04]), rtol=1e-9
    )


def test_non_rolling_radii_are_refused() -> None:
    with pytest.raises(InputError, match="closes at 60 mm between the axes, but they are 59"):
        mesh(ROUND.format(radius=1.05), name="own").pair()
