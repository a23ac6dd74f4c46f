"""Every spelling of a quantity that results print is accepted wherever a name is asked for, and no
other.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from planter.cli import dictionary
from planter.cli.explanation import explain_machine, find_meanings
from planter.engine.goal import resolve_limit, resolve_measure
from planter.engine.machine import Machine, load_machine
from planter.engine.measures import parse_limit, parse_sum
from planter.engine.outputs import find_output
from planter.engine.summary import PiecewiseCycle, build_rows, summarise
from planter.errors import InputError
from planter.files.spelling import find_spelled, list_spellings
from planter.mechanism.machines import build_machine
from planter.report.labels import format_name
from tests.support import own
from tests.support.cli import answer, run

FORCE = (
    "bearing A1",
    "F_A1",
    "bearing_A1",
    "Bearing A1",
    "bearing_A1_N",
    "force of the carrier on the middle shaft (bearing_A1)",
)


@pytest.fixture(scope="module")
def device() -> Machine:
    return load_machine("wang2017")


@pytest.mark.parametrize("name", FORCE)
def test_one_force_is_accepted_under_all_its_names(device: Machine, name: str) -> None:
    assert device.find_quantity(name).name == "bearing_A1"
    assert str(resolve_limit(device, parse_limit(f"{name} <= 0.3 kN"))) == "bearing_A1 <= 300 N"
    assert (
        str(resolve_measure(device, parse_sum(f"0.5 rms {name} + max M_L")[0]))
        == "0.5 rms bearing_A1"
    )
    assert find_output(device, f"max {name} [N]").terms[0].name == "bearing_A1"
    assert [meaning.name for meaning in dictionary.explain_name(name).meanings] == ["bearing_A1"]


def test_component_and_its_key_remain_the_component(device: Machine) -> None:
    for name in ("F_A1x", "F_A1x_N", "f_a1x"):
        assert device.find_quantity(name).name == "F_A1x"
    for name in ("bearing", "A1", "F_A1z", "bearing A2"):
        with pytest.raises(InputError, match="no quantity"):
            device.find_quantity(name)


def test_every_name_of_a_result_is_accepted(device: Machine) -> None:
    for machine in (device, own.machine("slider_crank")):
        for quantity in machine.results:
            page = f"{quantity.meaning} ({quantity.name})"
            for name in (quantity.name, quantity.key, format_name(quantity.key), page):
                assert machine.find_quantity(name).name == quantity.name
                assert parse_limit(f"max {name} <= 1").measure.kind == "max"
                assert (
                    machine.find_quantity(parse_limit(f"max {name} <= 1").measure.name).name
                    == quantity.name
                )
        for vector in machine.vectors:
            assert machine.find_quantity(format_name(vector.name)).name == vector.name
        for peak in summarise(PiecewiseCycle(machine, build_rows(machine))).peaks:
            assert machine.find_quantity(format_name(peak.name)).name == peak.name


def test_file_holds_limits_under_printed_names(tmp_path: Path) -> None:
    code, text, _ = run("example", "wang2017")
    assert code == 0
    limits = (
        '[requirements]\nhold = ["bearing A1 <= 300 N", "F_A1 <= 300 N", "teeth at P, normal '
        '(F_NP) <= 300 N"]\n'
    )
    (tmp_path / "own.toml").write_text(f"{text}\n{limits}", encoding="utf-8")
    holds = answer("validate", str(tmp_path / "own.toml"))["holds"]
    assert [limit["limit_on"] for limit in holds] == ["bearing_A1 <= 300 N"] * 2 + ["F_NP <= 300 N"]


def test_explanation_of_a_mechanism_knows_its_forces() -> None:
    source = str(own.generated("slider_crank") / "slider_crank.toml")
    explained = explain_machine(source, {})
    for name in ("F_B", "F B", "F_B_N"):
        (meaning,) = find_meanings(explained, name).meanings
        assert (meaning.name, meaning.components) == ("F_B", ["F_Bx", "F_By"])
    machine = build_machine(own.file("slider_crank"))
    assert machine.find_quantity("beta dot").name == "beta_dot"


def test_spelling_that_fits_two_names_is_refused() -> None:
    spellings = {name: list_spellings(name, f"{name}_N") for name in ("F_a", "F_A", "F_b")}
    assert find_spelled("F a", spellings) == ["F_a"]
    assert find_spelled("f a", spellings) == ["F_a", "F_A"]
    assert find_spelled("F_c", spellings) == []


@pytest.mark.parametrize(
    "text", ["max rmsF F_A <= 3", "maxx F_A <= 3", "max F_A while y z", "abbs F_A <= 1"]
)
def test_misspelt_words_of_the_language_are_no_names(text: str) -> None:
    with pytest.raises(InputError):
        resolve_limit(own.machine("slider_crank"), parse_limit(text))
