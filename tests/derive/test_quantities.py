"""Every symbol of every system has unit, meaning and source, and every step has the dimension of
what it defines.
"""

import pytest
import sympy as sp

from derive import papers
from derive.discovery import import_modules
from derive.generated_folder import GENERATED
from derive.generation import derive_models
from derive.mechanics import gearing
from derive.model import Let, System, join_entries, list_expressions
from derive.papers import wang2017
from derive.quantity import DimensionError, Quantity, dimension, of_unit
from tests.support.late import LateDict

SYSTEMS = LateDict(
    lambda: {
        model.name: model
        for model in derive_models((*import_modules(gearing), *import_modules(papers)))
    }
)
NAMES = sorted(
    p.stem
    for p in GENERATED.glob("*.json")
    if not p.stem.startswith(("audit", "curve_", "verdicts"))
)
"""Of the systems, as they are in `generated/`."""


def symbols(system: System) -> set[sp.Symbol]:
    used = {
        s
        for step in system.steps
        for e in list_expressions(step)
        for s in e.free_symbols | set(step.defines)
    }
    return used.union(*map(join_entries, system.inputs))


def undescribed(symbols_: set[sp.Symbol]) -> list[str]:
    described = (
        s for s in symbols_ if isinstance(s, Quantity) and s.unit and s.meaning and s.source
    )
    return sorted(str(s) for s in symbols_ - set(described))


@pytest.mark.parametrize("name", NAMES)
def test_every_symbol_is_described(name: str) -> None:
    assert undescribed(symbols(SYSTEMS[name])) == []


def test_every_system_is_looked_at() -> None:
    assert sorted(SYSTEMS) == NAMES


def test_a_bare_symbol_is_noticed() -> None:
    assert undescribed({*symbols(SYSTEMS["planting_exact"]), sp.Symbol("stranger", real=True)}) == [
        "stranger"
    ]


def test_a_quantity_without_meaning_is_refused() -> None:
    with pytest.raises(ValueError, match="unit, meaning and source"):
        Quantity("x", "m", "", "here")


@pytest.mark.parametrize("name", NAMES)
def test_each_name_has_a_single_unit(name: str) -> None:
    units: dict[str, set[str]] = {}
    for symbol in symbols(SYSTEMS[name]):
        units.setdefault(symbol.name, set()).add(symbol.unit)
    assert {name: unit_names for name, unit_names in units.items() if len(unit_names) > 1} == {}


@pytest.mark.parametrize("name", NAMES)
def test_steps_have_the_dimension_of_their_symbol(name: str) -> None:
    lets = [s for s in SYSTEMS[name].steps if isinstance(s, Let)]
    assert len(lets) > (15 if SYSTEMS[name].lane else 0)
    for let in lets:
        assert dimension(let.expr) in (None, of_unit(let.symbol.unit)), let.symbol


def test_equations_7_and_31_of_wang2017_mix_dimensions() -> None:
    """One prints a rate where an acceleration has to stand, the other adds a force to the square of
    one.
    """
    mixed = []
    for number, equation in wang2017.PAPER.equations.items():
        try:
            dimension(equation.residual)
        except DimensionError:
            mixed.append(number)
    assert mixed == ["7", "31"]


def test_equal_names_with_two_units_are_two_quantities() -> None:
    """SymPy remembers products; one paper's symbol must not come back for another's of the same
    name.
    """
    length, number = Quantity("zz", "m", "test", "test"), Quantity("zz", "1", "test", "test")
    assert dimension(2 * length) == of_unit("m")
    assert dimension(2 * number) == of_unit("1")
    assert length != number


def test_decimal_powers_have_the_dimension_of_fractions() -> None:
    length, mass = Quantity("zz", "m", "test", "test"), Quantity("zm", "kg", "test", "test")
    assert dimension(length**1.5 * mass**2.0) == dimension(length ** sp.Rational(3, 2) * mass**2)
    assert dimension(length**1.5 / length**0.5) == of_unit("m")
    with pytest.raises(DimensionError, match="no fraction"):
        dimension(length**0.1234567)


@pytest.mark.parametrize(
    ("unit", "exponents"),
    [
        ("kg m2", (1, 2, 0)),
        ("m/s2", (0, 1, -2)),
        ("N m", (1, 2, -2)),
        ("rad/s", (0, 0, -1)),
        ("N/m", (1, 0, -2)),
        ("1", (0, 0, 0)),
    ],
)
def test_units(unit: str, exponents: tuple[int, int, int]) -> None:
    assert of_unit(unit) == exponents
