"""Texts of figures neither overlap nor are cut, whatever command draws them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pytest
from matplotlib.figure import Figure

from planter.report import bundle, style
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
EMPTY = {"svg": style.render_svg(style.new_figure(1.0))}


def collect_faults(
    words: list[str], folder: Path, monkeypatch: pytest.MonkeyPatch
) -> tuple[int, list[str]]:
    """Run a command that draws, without rendering, and return the number of its figures and the
    faults of these.
    """
    figures: dict[str, Figure] = {}

    def keep(plots: Mapping[str, Figure], _: object = None) -> dict[str, bundle.RenderedFigure]:
        figures.update(plots)
        return dict.fromkeys(plots, EMPTY)

    monkeypatch.setattr(bundle, "render_figures", keep)
    code, _, error = run(*words, "--out", str(folder))
    assert code == 0, error
    return len(figures), [
        f"{name}: {fault}" for name, figure in figures.items() for fault in find_text_faults(figure)
    ]


@pytest.mark.parametrize(
    "command",
    [*COMMANDS, *(f"simulate {name}" for name in OWN), pytest.param(SLOW, marks=pytest.mark.long)],
)
def test_texts_neither_overlap_nor_are_cut(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    words = [
        str(own.generated(word) / f"{word}.toml") if word in OWN else word
        for word in command.split()
    ]
    monkeypatch.chdir(ROOT)
    count, faults = collect_faults(words, tmp_path, monkeypatch)
    assert count
    assert faults == []


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
