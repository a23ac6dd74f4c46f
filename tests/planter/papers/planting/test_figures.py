"""Figures: what is drawn is what was handed in, it fits on the sheet, and the same data give the
same bytes.
"""

from __future__ import annotations

import subprocess
import sys
import threading
from collections.abc import Callable

import matplotlib
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from planter.papers.planting.report import forces as figures
from planter.report import style
from tests.support.sampled import sampled

PHI = np.arange(360.0)


STEADY = 98 + np.sin(np.radians(2 * PHI))
LIVELY = 77 + 45 * np.sin(np.radians(2 * PHI))
CYCLES = {"exact": (PHI, STEADY), "printed": (PHI, LIVELY)}
BEFORE = {"exact": (PHI, STEADY + 0.2), "printed": (PHI, LIVELY - 3)}
JOINTS = {
    "sun, t = 0": [-25.5, 154.5],
    "cam, start of the rise": [131.0],
    "cam, end of the rise": [181.0],
}


FIGURES: dict[str, Callable[[], Figure]] = {
    "support force": lambda: figures.draw_support_force(CYCLES, 97.86, JOINTS, BEFORE),
    "support force, plain": lambda: figures.draw_support_force({"exact": CYCLES["exact"]}, 97.86),
}


def line(axes: Axes, label: str) -> Line2D:
    """The only line of that label."""
    (matching,) = [line for line in axes.get_lines() if line.get_label() == label]
    return matching


def data(axes: Axes, label: str) -> np.ndarray:
    return np.asarray(line(axes, label).get_xydata()).T


# --- every figure
# ----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", FIGURES)
def test_every_axis_has_a_unit(name: str) -> None:
    labels = [
        label
        for axes in FIGURES[name]().axes
        for label in (axes.get_xlabel(), axes.get_ylabel())
        if label
    ]
    units = (" / N", " / N²", " / mm", " / deg", " / (rad/s)", " / 1")
    counts = ("evaluations of the objective", "best objective")
    assert labels
    assert [label for label in labels if not label.endswith(units) and label not in counts] == []


@pytest.mark.parametrize(
    "name",
    sampled(
        [
            "support force",
        ],
        FIGURES,
    ),
)
def test_the_same_data_give_the_same_bytes(name: str) -> None:
    first = style.render_svg(FIGURES[name]())
    assert style.render_svg(FIGURES[name]()) == first
    assert "<dc:date>" not in first


@pytest.fixture(scope="module")
def single_drawing() -> str:
    """Drawn alone, under nobody's settings."""
    return style.render_svg(FIGURES["support force"]())


def test_settings_of_the_user_play_no_part_and_stay(single_drawing: str) -> None:
    with matplotlib.rc_context({"font.size": 20, "lines.linewidth": 9, "svg.hashsalt": "mine"}):
        assert style.render_svg(FIGURES["support force"]()) == single_drawing
        assert matplotlib.rcParams["font.size"] == 20
        assert matplotlib.rcParams["svg.hashsalt"] == "mine"


def test_threads_do_not_disturb_each_other(single_drawing: str) -> None:
    together: list[str] = []
    threads = [
        threading.Thread(
            target=lambda: together.append(style.render_svg(FIGURES["support force"]()))
        )
        for _ in "12"
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert together == [single_drawing] * 2


def test_matplotlib_is_imported_by_the_first_figure() -> None:
    script = (
        "import sys; from planter.report import files, html;"
        "from planter.papers.planting.report import forces as figures; "
        "import planter.papers.planting.design_presentation;"
        "before = 'matplotlib' in sys.modules; "
        "import numpy as np; x = np.arange(2.0);"
        "figures.draw_support_force({'exact': (x, x)}, 1.0);"
        "print(before, 'matplotlib' in sys.modules, 'matplotlib.pyplot' in sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == ["False", "True", "False"]


# --- forces
# ----------------------------------------------------------------------------------------


def test_support_force_shows_both_models_and_the_weight() -> None:
    axes = figures.draw_support_force(CYCLES, 97.86).axes[0]
    for model, curve in CYCLES.items():
        assert np.array_equal(data(axes, model), curve)
    assert set(data(axes, "weight")[1]) == {97.86}
    assert "weight 97.9 N" in [text.get_text() for text in axes.texts]
    assert to_hex(line(axes, "exact").get_color()) != to_hex(line(axes, "printed").get_color())


def test_flat_curve_is_repeated_on_a_zoomed_axis() -> None:
    common, zoomed = figures.draw_support_force(CYCLES, 97.86).axes
    assert np.array_equal(data(zoomed, "exact"), CYCLES["exact"])
    assert [line.get_label() for line in zoomed.get_lines()] == ["exact", "weight"]
    assert np.ptp(zoomed.get_ylim()) < 0.1 * np.ptp(common.get_ylim())
    assert len(figures.draw_support_force({"exact": CYCLES["exact"]}, 97.86).axes) == 1


def test_the_design_before_is_dashed() -> None:
    common, zoomed = figures.draw_support_force(CYCLES, 97.86, before=BEFORE).axes
    for axes, model in ((common, "printed"), (common, "exact"), (zoomed, "exact")):
        assert np.array_equal(data(axes, f"{model}, before"), BEFORE[model])
        assert line(axes, f"{model}, before").is_dashed()
        assert not line(axes, model).is_dashed()


def test_ranges_stand_above_their_curves() -> None:
    common, zoomed = figures.draw_support_force(CYCLES, 97.86, before=BEFORE).axes
    assert common.get_title(loc="left").startswith("range: exact 2 to 2 N, printed 90 to 90 N")
    assert zoomed.get_title(loc="left").startswith(
        "exact model on its own scale; range: exact 2 to 2 N"
    )


def test_joints_are_marked_part_by_part() -> None:
    common, _, strip = figures.draw_support_force(CYCLES, 97.86, JOINTS).axes
    assert np.array_equal(data(strip, "sun")[0], [334.5, 154.5])
    assert np.array_equal(data(strip, "cam")[0], [131.0, 181.0])
    marked = sorted(
        float(np.asarray(line.get_xdata())[0])
        for line in common.get_lines()
        if line.get_gid() == "joint"
    )
    assert marked == [131.0, 154.5, 181.0, 334.5]


# --- motion
# ----------------------------------------------------------------------------------------


# --- search
# ----------------------------------------------------------------------------------------
