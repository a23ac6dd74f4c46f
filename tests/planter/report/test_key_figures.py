"""Key figures: the value and the unit of each belong to its name, whatever command presents it;
counts in words.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from planter.files import units
from planter.report.html import KeyFigure, Section, Table
from planter.report.presentation import ResultPresentation, find_key_figures
from tests.support import own
from tests.support.cli import run
from tests.support.structure import ROOT

COMMANDS = (
    "simulate wang2017",
    "validate wang2017",
    "sensitivity wang2017",
    "diff wang2017 wang2017-wide",
    "cam wang2017 --roller-mm 6",
    "drive wang2017 --stall-Nm 6 --idle-rpm 42 --flywheel-kgm2 0.1",
    "gears wang2017 --module 2",
    "optimise wang2017 --method ipopt --starts 1",
    "pickup yu2023",
    "synthesise sun2019",
    "synthesise sun2019-corrected",
    "train sun2019-curve --crank-mm 30",
    "clutch geometry shi2021",
    "clutch engage shi2021",
    "clutch field",
    "clutch design shi2021",
    "clutch rotor",
    "explain wang2017",
    "audit wang2017",
    "sweep tests/support/sweep_speed.toml",
    "simulate slider_crank",
    "sensitivity slider_crank --least rms,F_Ox",
    "optimise slider_crank --least rms,F_Ox --starts 1",
    "validate slider_crank",
    "explain slider_crank",
    "drive slider_crank --stall-Nm 20 --idle-rpm 400 --flywheel-kgm2 0.1",
    "move gear_rattle --until 0.02 --points 31",
    "calibrate slider_crank --data DATA --angle phi_deg --column N_guide_N --quantity N_guide "
    "--fit m_s_kg=1:2",
    "calibrate slider_crank --data DATA --preview --angle phi_deg --column N_guide_N --quantity "
    "N_guide",
)
OWN = ("slider_crank", "gear_rattle")
NUMBER = re.compile(r"[\N{MINUS SIGN}-]?\d+(\.\d+)?(e[+-]?\d+)?")


def present(words: list[str], monkeypatch: pytest.MonkeyPatch) -> list[ResultPresentation]:
    """Return what a command presents."""
    presented: list[ResultPresentation] = []
    monkeypatch.setattr(ResultPresentation, "show", lambda self, *_: presented.append(self))
    code, _, error = run(*words)
    assert code == 0, error
    return presented


def list_numbers(value: Any, unit: str = "", key: str = "") -> Iterator[tuple[float, set[str]]]:
    """Yield the numbers of a result with the units that they can have: of their keys, and of `unit`
    beside them.

    An integer counts something, so that a unit beside it is not its own.
    """
    if isinstance(value, dict):
        row_unit = str(value.get("unit") or unit)
        for name, inner in value.items():
            unit_of_name = units.display_unit(name)
            if key == "gradient":
                yield float(inner), {f"1/{unit_of_name}" if unit_of_name else ""}
                continue
            yield from list_numbers(
                inner, row_unit, name if unit_of_name or not units.display_unit(key) else key
            )
    elif isinstance(value, list | tuple):
        for inner in value:
            yield from list_numbers(inner, unit, key)
    elif isinstance(value, int | float) and not isinstance(value, bool):
        of_key = units.display_unit(key)
        yield float(value), {of_key} if of_key else {""} if isinstance(value, int) else {unit, ""}


def find_fault(figure: KeyFigure, numbers: list[tuple[float, set[str]]]) -> str | None:
    """Return why the value of a figure is none of a result in its unit, None if it is one."""
    text = figure.value.replace("\N{MINUS SIGN}", "-")
    if not NUMBER.fullmatch(text):
        return None
    printed = float(text)
    digits = len(re.sub(r"e.*|\D", "", text).lstrip("0")) or 1
    units_found = [unit for value, unit in numbers if float(f"{value:.{digits}g}") == printed]
    if not units_found:
        return (
            None
            if printed == 0 or figure.unit in ("", "%")
            else f"{figure.value} {figure.unit} is no number of the result"
        )
    allowed = set().union(*units_found)
    if (
        figure.unit == "R" and "" in allowed
    ):  # lengths of the clutch's shape are shares of the polygon's radius
        return None
    return (
        None
        if figure.unit in allowed
        else f"{figure.meaning}: {figure.value} is in {allowed}, not {figure.unit}"
    )


def list_faults(presentation: ResultPresentation) -> list[str]:
    numbers = list(list_numbers(presentation.record.table()))
    figures = presentation.key_figures or find_key_figures(presentation.sections)
    return [fault for figure in figures if (fault := find_fault(figure, numbers)) is not None]


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A curve of the slider-crank's guide with noise, in newtons."""
    machine = own.machine("slider_crank")
    angles = np.radians(np.arange(0, 360, 2.0))
    force = own.evaluate_lane(own.file("slider_crank"), angles)["N_guide"]
    assert machine.name == "slider_crank"
    noisy = force + np.random.default_rng(1).normal(0, 0.2, len(force))
    path = tmp_path_factory.mktemp("data") / "measured.csv"
    rows = "".join(
        f"{np.degrees(angle):.6g},{value:.6g}\n" for angle, value in zip(angles, noisy, strict=True)
    )
    path.write_text(f"phi_deg,N_guide_N\n{rows}", encoding="utf-8")
    return path


@pytest.mark.parametrize("command", COMMANDS)
def test_key_figures_are_numbers_in_their_unit(
    command: str, data: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    words = [
        str(own.generated(word) / f"{word}.toml") if word in OWN else word
        for word in command.split()
    ]
    words = [str(data) if word == "DATA" else word.replace(",", " ") for word in words]
    monkeypatch.chdir(ROOT)
    for presentation in present(words, monkeypatch):
        assert list_faults(presentation) == []
        assert not re.search(r"\b1 (?!of\b)\w+ \w*s\b|All 1 ", presentation.conclusion), (
            presentation.conclusion
        )


def test_count_with_the_unit_of_its_row_is_found() -> None:
    numbers = list(
        list_numbers(
            {"channels": [{"column": "force", "unit": "N", "used": 997, "noise_std": 0.05}]}
        )
    )
    assert find_fault(KeyFigure("997", "N", "Data, force, used"), numbers) is not None
    assert find_fault(KeyFigure("0.05", "N", "Data, force, noise"), numbers) is None
    assert find_fault(KeyFigure("0.05", "mm", "Data, force, noise"), numbers) is not None


def test_row_with_a_unit_opens_with_a_size_not_a_count() -> None:
    table = Table(("column", "unit", "used", "noise"), [("force", "N", 997, 0.05)])
    (figure,) = find_key_figures([Section("Data", [table])])
    assert (figure.value, figure.unit, figure.meaning) == ("0.05", "N", "Data, force, noise")
