"""Every operation that can be printed, against CasADi's virtual machine, at random and at awkward
points.
"""

from functools import cache
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from planter.kernels import backends
from planter.kernels.backends import Array, LaneTask
from planter.kernels.lane_graph import OPERATIONS
from tests.support.lanes import evaluated, for_processor, needs_compiler, work

pytestmark = [needs_compiler, pytest.mark.usefixtures("kernel_cache")]

a, b = ca.SX.sym("a"), ca.SX.sym("b")
RNG = np.random.default_rng(4)
SMALL = np.concatenate(
    [RNG.normal(size=40), [0.0, -0.0, 1.0, -1.0, 0.5, 1e-300, -1e-8, 700.0, -700.0]]
)
UNIT = np.concatenate([RNG.uniform(-1, 1, 40), [0.0, -0.0, 1.0, -1.0, 1e-9, 1 - 1e-15]])
WITHIN = UNIT[np.abs(UNIT) < 1]
POSITIVE = np.concatenate([RNG.exponential(size=40), [1e-300, 1e-8, 1.0, 1 + 1e-15, 1e300]])
QUARTERS = np.arange(-9, 10) * np.pi / 2
ANGLES = np.concatenate(
    [
        RNG.uniform(-20, 20, 60),
        QUARTERS,
        np.nextafter(QUARTERS, 9),
        [0.0, -0.0, 1e-12],
        RNG.uniform(-1e3, 1e3, 40),
        1e6 * RNG.normal(size=40),
        1e9 * RNG.normal(size=40),
    ]
)
STEPS = np.arange(-5.0, 6.0)
HUGE = [2.0**31 - 1.5, 1.5 - 2.0**31, 2.0**52 + 1, 1e300, -1e300]
WHOLE = np.concatenate([RNG.uniform(-9, 9, 60), STEPS, np.nextafter(STEPS, -9), [-0.0], HUGE])
BEYOND = np.array([2.0**31 - 0.5, 0.5 - 2.0**31, 2.0**31 + 0.5, -(2.0**40) - 0.25])
PAIRS = np.array(
    [
        *RNG.normal(size=(40, 2)),
        (1.0, 1.0),
        (2.0, 1.0),
        (1.0, 2.0),
        (0.0, -0.0),
        (-0.0, 0.0),
        (0.0, 1.0),
        (-1.0, 0.0),
        (0.0, 0.0),
        (1e300, 1e-3),
        (-3.0, -3.0),
    ]
).T
DIVIDED = PAIRS[:, PAIRS[1] != 0]
POWERS = np.array(
    [
        *zip(RNG.exponential(size=40), 3 * RNG.normal(size=40), strict=True),
        (0.0, 2.0),
        (1.0, 1e6),
        (2.0, -3.0),
        (9.0, 0.5),
        (-2.0, 3.0),
        (-2.0, 2.0),
        (4.0, 0),
    ]
).T
REMAINDERS = np.array(
    [*RNG.normal(size=(40, 2)), (-7.5, 2.0), (7.5, -2.0), (6.0, 2.0), (1e10, 0.1), (0.0, 3.0)]
).T
BITS = np.array([(p, q) for p in (0.0, 1.0, -0.0) for q in (0.0, 1.0)]).T

SINGLE = {
    "neg": (-a, SMALL),
    "inv": (1 / a, SMALL[SMALL != 0]),
    "sq": (a**2, SMALL),
    "twice": (2 * a, SMALL),
    "sign": (ca.sign(a), SMALL),
    "not": (ca.logic_not(a), SMALL),
    "sin": (ca.sin(a), ANGLES),
    "cos": (ca.cos(a), ANGLES),
    "sqrt": (ca.sqrt(a), np.append(POSITIVE, [0.0, -0.0])),
    "fabs": (ca.fabs(a), SMALL),
    "floor": (ca.floor(a), WHOLE),
    "ceil": (ca.ceil(a), WHOLE),
    "exp": (ca.exp(a), SMALL),
    "log": (ca.log(a), POSITIVE),
    "constpow": (a**3.7, np.append(POSITIVE[POSITIVE < 1e50], 0.0)),
    "constpow, negative base": (a**-3, np.array([-2.0, 3.0, -0.1])),
    "tan": (ca.tan(a), ANGLES[np.abs(ANGLES) < 1e4]),
    "asin": (ca.asin(a), UNIT),
    "acos": (ca.acos(a), UNIT),
    "atan": (ca.atan(a), np.append(SMALL, [1e300, -1e300])),
    "sinh": (ca.sinh(a), SMALL),
    "cosh": (ca.cosh(a), SMALL),
    "tanh": (ca.tanh(a), SMALL),
    "asinh": (ca.asinh(a), SMALL),
    "acosh": (ca.acosh(a), 1 + POSITIVE),
    "atanh": (ca.atanh(a), WITHIN),
    "log1p": (ca.log1p(a), np.append(POSITIVE, WITHIN)),
    "expm1": (ca.expm1(a), SMALL),
    "erf": (ca.erf(a), SMALL),
}
DOUBLE = {
    "add": (a + b, PAIRS),
    "sub": (a - b, PAIRS),
    "mul": (a * b, PAIRS),
    "div": (a / b, DIVIDED),
    "lt": (a < b, PAIRS),
    "le": (a <= b, PAIRS),
    "eq": (ca.eq(a, b), PAIRS),
    "ne": (ca.ne(a, b), PAIRS),
    "and": (ca.logic_and(a, b), BITS),
    "or": (ca.logic_or(a, b), BITS),
    "if_else_zero": (ca.if_else(a, b, 0), PAIRS),
    "fmin": (ca.fmin(a, b), PAIRS),
    "fmax": (ca.fmax(a, b), PAIRS),
    "copysign": (ca.copysign(a, b), PAIRS),
    "pow": (a**b, POWERS),
    "atan2": (ca.atan2(a, b), PAIRS),
    "hypot": (ca.hypot(a, b), PAIRS),
    "fmod": (ca.fmod(a, b), REMAINDERS),
}
SCALES = {"sin": 1.0, "cos": 1.0}
"""Results that are measured by a fixed value, since the angle itself is only known to its last
digit.
"""


@cache
def single() -> LaneTask:
    return work("a", {f"y{i}": y for i, (y, _) in enumerate(SINGLE.values())}, [a], "a")


@cache
def double() -> LaneTask:
    return work("a b", {f"y{i}": y for i, (y, _) in enumerate(DOUBLE.values())}, [a, b], "a b")


def test_every_operation_is_tested_here() -> None:
    met = {
        f.instruction_id(i)
        for f in (single().function, double().function)
        for i in range(f.n_instructions())
    }
    assert set(OPERATIONS) - met == set()


def check(name: str, task: LaneTask, way: backends.Backend, index: int, *points: Array) -> None:
    with np.errstate(all="ignore"):
        actual, expected = (
            evaluated(task, w, *points)[f"y{index}"][0]
            for w in (way, backends.VirtualMachine(task))
        )
    assert np.isfinite(expected).all()
    size = np.maximum(np.abs(expected), SCALES.get(name, 1e-300))
    worst = int(np.argmax(np.abs(actual - expected) / size))
    assert np.abs(actual - expected)[worst] <= 2e-15 * size[worst], [p[worst] for p in points]


@pytest.fixture(scope="module", params=["native", "x86-64"])
def ways_of(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> tuple[backends.Backend, backends.Backend]:
    if request.param == "native":
        return backends.build_compiled(single(), "lanes"), backends.build_compiled(
            double(), "lanes"
        )
    folder: Path = tmp_path_factory.mktemp("plain")
    first, second = (
        for_processor(w, request.param, folder / n) for n, w in (("1", single()), ("2", double()))
    )
    return first, second


@pytest.mark.parametrize("name", SINGLE)
def test_unary_operations(name: str, ways_of: tuple[backends.Backend, backends.Backend]) -> None:
    check(name, single(), ways_of[0], list(SINGLE).index(name), SINGLE[name][1])


def test_floor_of_non_angles(ways_of: tuple[backends.Backend, backends.Backend]) -> None:
    """Without a vector instruction for it, numbers beyond 32 bits are left as they are; else they
    have their floor.
    """
    actual = evaluated(single(), ways_of[0], BEYOND)[f"y{list(SINGLE).index('floor')}"][0]
    assert (actual == np.floor(BEYOND)).all() or (actual == BEYOND).all()


@pytest.mark.parametrize("name", DOUBLE)
def test_of_two_numbers(name: str, ways_of: tuple[backends.Backend, backends.Backend]) -> None:
    check(name, double(), ways_of[1], list(DOUBLE).index(name), *DOUBLE[name][1])
