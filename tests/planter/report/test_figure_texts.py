"""Texts of figures neither overlap nor are cut, whatever command draws them, and results are named
in words.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

import pytest
from matplotlib.figure import Figure

from planter.report import files, style
from tests.support import own
from tests.support.cli import run
from tests.support.figure_texts import find_text_faults
from tests.support.structure import ROOT

COMMANDS = (
    "simulate wang2017",
    "simulate wang2017-wide",
    "diff wang2017 wang2017-wide",
    "cam wang2017 --roller-mm 6",
    "drive wang2017 --stall-Nm 6 --idle-rpm 42 --flywheel-kgm2 0.1",
    "gears wang2017 --module 2",
    "optimise wang2017 --method ipopt --starts 1",
    "pickup yu2023",
    "pickup yu2023 --optimise",
    "synthesise sun2019",
    "synthesise sun2019-corrected",
    "train sun2019-curve --crank-mm 30",
    "clutch geometry shi2021",
    "clutch engage shi2021",
    "clutch field",
    "clutch design shi2021",
    "clutch optimise shi2021 --starts 1",
    "clutch rotor",
    "explain wang2017",
    "explain yu2023",
    "explain shi2021",
    "explain sun2019",
    "diff yu2023 yu2023",
    "sweep tests/support/sweep_speed.toml",
)
SLOW = "tolerance wang2017 --tolerances docs/examples/tolerances.toml --samples 128"
OWN = ("slider_crank", "cam_follower", "rssr")
NAMED = (
    "clutch geometry shi2021",
    "clutch engage shi2021",
    "clutch design shi2021",
    "clutch optimise shi2021 --starts 1",
    "clutch rotor",
    "clutch field",
    "train sun2019-curve --crank-mm 30",
    "synthesise sun2019",
)
"""Commands whose terminal names every value in words."""
RAW = re.compile(r"\w*[A-Za-z]_\w+")
EMPTY = {"svg": style.render_svg(style.new_figure(1.0))}


def find_raw_keys(text: str) -> list[str]:
    """Return the keys of a printed text that do not stand alone in the last column, to the right of
    a name.
    """
    left = [re.sub(r"(?<=\s)\S+\s*$", "", line) for line in text.splitlines()]
    return [key for line in left for key in RAW.findall(line)]


@pytest.mark.parametrize(
    "command",
    [*COMMANDS, *(f"simulate {name}" for name in OWN), pytest.param(SLOW, marks=pytest.mark.long)],
)
def test_texts_neither_overlap_nor_are_cut(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    figures: dict[str, Figure] = {}

    def keep(plots: Mapping[str, Figure], _: object = None) -> dict[str, files.RenderedFigure]:
        figures.update(plots)
        return dict.fromkeys(plots, EMPTY)

    words = command.split()
    if words[1] in OWN:
        words[1] = str(own.generated(words[1]) / f"{words[1]}.toml")
    monkeypatch.setattr(files, "render_figures", keep)
    monkeypatch.chdir(ROOT)
    code, text, error = run(*words, "--out", str(tmp_path))
    assert code == 0, error
    assert figures
    faults = {name: find_text_faults(figure) for name, figure in figures.items()}
    assert not [name for name in faults if faults[name]], faults
    assert command not in NAMED or find_raw_keys(text) == []


@style.with_style
def draw_texts(x: float, rotation: float) -> Figure:
    figure = style.new_figure(2.0)
    figure.set_layout_engine("none")
    figure.text(0.5, 0.5, "first")
    figure.text(x, 0.5, "second", rotation=rotation)
    return figure


@pytest.mark.parametrize(
    ("x", "rotation", "fault"),
    [
        (0.52, 0, "'first' overlaps 'second'"),
        (0.52, 45, "'first' overlaps 'second'"),
        (0.99, 0, "'second' is cut"),
    ],
)
def test_faults_are_found(x: float, rotation: float, fault: str) -> None:
    assert find_text_faults(draw_texts(x, rotation)) == [fault]
    assert find_text_faults(draw_texts(0.7, rotation)) == []
