"""Figures: what is drawn is what was handed in, it fits on the sheet, and the same data give the
same bytes.
"""

from __future__ import annotations

import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Polygon
from matplotlib.text import Text
from matplotlib.transforms import Bbox

from planter.errors import InputError
from planter.planting.report import figures
from planter.planting.toothed import Gearing, PlottedPitchCurve
from planter.report import style
from tests.support.sampled import sampled

PHI = np.arange(360.0)
LENGTH = 210.0


def turn(travel: float = 0.0) -> dict[str, np.ndarray]:
    """Columns of a turn, made up: a carrier with two links, a nozzle that swings and opens for a
    while.
    """
    phi = np.radians(PHI)
    a1 = 62 * np.array([-np.sin(phi), np.cos(phi)])
    b1 = a1 + 61 * np.array([-np.sin(phi + 0.5), np.cos(phi + 0.5)])
    alpha = np.radians(100) + 0.3 * np.sin(phi)
    tip = b1 + LENGTH * np.array([np.cos(alpha), -np.sin(alpha)])
    forces = {
        f"{name}{axis}_N": size
        * (np.sin(2 * phi + k) + 0.3 * np.cos(phi) * (name in ("F_A1", "F_B1")))
        for name, size in (("F_A1", 50), ("F_B1", 80), ("F_O", 30), ("F_O1", 60))
        for k, axis in enumerate("xy")
    }
    return {
        "phi_deg": PHI,
        "phi52_deg": PHI + 20 * np.sin(phi),
        "phi72_deg": -PHI - 25 * np.sin(phi),
        "omega_rad_s": 1.5 * np.sin(phi),
        "alpha_deg": np.degrees(alpha),
        "theta1_deg": np.where((PHI > 150) & (PHI < 300), 18.0, 0.0),
        **{
            f"{axis}_{name}_mm": point[i]
            for name, point in (("A1", a1), ("B1", b1))
            for i, axis in enumerate("xy")
        },
        "tip_machine_x_mm": tip[0],
        "tip_x_mm": tip[0] + travel * phi,
        "tip_y_mm": tip[1],
        **forces,
    }


STEADY = 98 + np.sin(np.radians(2 * PHI))
LIVELY = 77 + 45 * np.sin(np.radians(2 * PHI))
CYCLES = {"exact": (PHI, STEADY), "printed": (PHI, LIVELY)}
BEFORE = {"exact": (PHI, STEADY + 0.2), "printed": (PHI, LIVELY - 3)}
JOINTS = {
    "sun, t = 0": [-25.5, 154.5],
    "cam, start of the rise": [131.0],
    "cam, end of the rise": [181.0],
}


def mesh() -> Gearing:
    """Four circles that touch, one above the other."""
    t = np.linspace(0, 2 * np.pi, 90)
    centres = [np.array([0.0, y]) for y in (0, 60, 60, 120)]
    curves = [
        PlottedPitchCurve(name, centre, centre[:, None] + 30 * np.array([np.cos(t), np.sin(t)]))
        for name, centre in zip(("sun", "gear 5", "gear 6", "planet gear"), centres, strict=True)
    ]
    contacts = {"P": np.array([0.0, 30.0]), "Q": np.array([0.0, 90.0])}
    return Gearing(
        0.0, tuple(curves), {"O": centres[0], "A1": centres[1], "B1": centres[3]}, contacts
    )


FIGURES: dict[str, Callable[[], Figure]] = {
    "support force": lambda: figures.draw_support_force(CYCLES, 97.86, JOINTS, BEFORE),
    "support force, plain": lambda: figures.draw_support_force({"exact": CYCLES["exact"]}, 97.86),
    "tip path": lambda: figures.draw_tip_path(turn()),
    "tip path, travelling": lambda: figures.draw_tip_path(turn(-160.0)),
    "pitch curves": lambda: figures.draw_pitch_curves(mesh()),
    "tip path, soil and before": lambda: figures.draw_tip_path(turn(-160.0), turn(), -300.0),
    "pitch curves, before": lambda: figures.draw_pitch_curves(mesh(), mesh()),
}


def line(axes: Axes, label: str) -> Line2D:
    """The only line of that label."""
    (matching,) = [line for line in axes.get_lines() if line.get_label() == label]
    return matching


def data(axes: Axes, label: str) -> np.ndarray:
    return np.asarray(line(axes, label).get_xydata()).T


# --- every figure
# ----------------------------------------------------------------------------------


def outside(figure: Figure) -> list[str]:
    """Texts that reach beyond the sheet."""
    style.fix_layout(figure)
    figure.draw_without_rendering()
    box = figure.bbox.padded(0.5)
    return [
        text
        for text, e in texts(figure)
        if not (box.contains(e.x0, e.y0) and box.contains(e.x1, e.y1))
    ]


def texts(figure: Figure) -> list[tuple[str, Bbox]]:
    texts = [t for t in figure.findobj(Text) if t.get_visible() and t.get_text().strip()]
    hidden = {
        id(label)
        for axes in figure.axes
        for axis in (axes.xaxis, axes.yaxis)
        for tick in axis.get_major_ticks() + axis.get_minor_ticks()
        for label in (tick.label1, tick.label2)
        if not min(axis.get_view_interval()) <= tick.get_loc() <= max(axis.get_view_interval())
    }
    return [(t.get_text(), t.get_window_extent()) for t in texts if id(t) not in hidden]


@pytest.mark.parametrize("name", FIGURES)
def test_no_text_is_cut_off(name: str) -> None:
    assert outside(FIGURES[name]()) == []


def test_cut_text_is_detected() -> None:
    figure = FIGURES["pitch curves"]()
    figure.text(0.98, 0.5, "much too far to the right")
    assert outside(figure) == ["much too far to the right"]


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
            "tip path, soil and before",
            "pitch curves, before",
        ],
        FIGURES,
    ),
)
def test_the_same_data_give_the_same_bytes(name: str) -> None:
    first = figures.render_svg(FIGURES[name]())
    assert figures.render_svg(FIGURES[name]()) == first
    assert "<dc:date>" not in first


def test_earlier_figures_have_no_influence() -> None:
    figure = FIGURES["tip path"]()
    first = figures.render_svg(figure)
    assert style.render_png(figure) == style.render_png(FIGURES["tip path"]())
    assert figures.render_svg(figure) == first


@pytest.fixture(scope="module")
def drawn_alone() -> str:
    """Drawn alone, under nobody's settings."""
    return figures.render_svg(FIGURES["pitch curves"]())


def test_settings_of_the_user_play_no_part_and_stay(drawn_alone: str) -> None:
    with matplotlib.rc_context({"font.size": 20, "lines.linewidth": 9, "svg.hashsalt": "mine"}):
        assert figures.render_svg(FIGURES["pitch curves"]()) == drawn_alone
        assert matplotlib.rcParams["font.size"] == 20
        assert matplotlib.rcParams["svg.hashsalt"] == "mine"


def test_threads_do_not_disturb_each_other(drawn_alone: str) -> None:
    together: list[str] = []
    threads = [
        threading.Thread(
            target=lambda: together.append(figures.render_svg(FIGURES["pitch curves"]()))
        )
        for _ in "12"
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert together == [drawn_alone] * 2


def test_matplotlib_is_imported_by_the_first_figure() -> None:
    script = (
        "import sys; from planter.report import files, html;"
        "from planter.planting.report import figures; import planter.planting.design_presentation;"
        "before = 'matplotlib' in sys.modules; "
        "import numpy as np; x = np.arange(2.0);"
        "figures.draw_support_force({'exact': (x, x)}, 1.0);"
        "print(before, 'matplotlib' in sys.modules, 'matplotlib.pyplot' in sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == ["False", "True", "False"]


def test_both_files_are_saved(tmp_path: Path) -> None:
    figure = FIGURES["pitch curves"]()
    assert figures.save_figure(figure, tmp_path, "pitch") == figures.render_svg(figure)
    assert (tmp_path / "pitch.svg").read_text(encoding="utf-8") == figures.render_svg(figure)
    assert (tmp_path / "pitch.png").read_bytes().startswith(b"\x89PNG")
    assert {path.name for path in tmp_path.iterdir()} == {
        "pitch.svg",
        "pitch.pdf",
        "pitch.png",
        ".planter.json",
    }
    assert (tmp_path / "pitch.pdf").read_bytes() == figures.style.render_pdf(figure)


def test_missing_folder_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="nowhere"):
        figures.save_figure(FIGURES["pitch curves"](), tmp_path / "nowhere", "pitch")


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


def test_tip_path_is_the_nozzle_end_at_every_angle() -> None:
    columns = turn()
    (axes,) = figures.draw_tip_path(columns).axes
    x, y = data(axes, "tip, closed")
    assert np.allclose(x[:-1], columns["tip_x_mm"], atol=1e-9, rtol=0)
    assert np.allclose(y[:-1], columns["tip_y_mm"], atol=1e-9, rtol=0)
    assert (x[-1], y[-1]) == (x[0], y[0])
    assert axes.get_aspect() == 1


def test_nozzle_is_drawn_at_twelve_angles() -> None:
    columns = turn()
    (axes,) = figures.draw_tip_path(columns).axes
    outlines = [np.asarray(p.get_xy()) for p in axes.findobj(Polygon) if p.get_gid() == "nozzle"]
    tips = np.array([columns["tip_x_mm"], columns["tip_y_mm"]]).T[::30]
    roots = np.array([columns["x_B1_mm"], columns["y_B1_mm"]]).T[::30]
    assert len(outlines) == 12
    for outline, tip, root in zip(outlines, tips, roots, strict=True):
        assert np.hypot(*(outline - tip).T).min() < 1e-9
        assert np.hypot(*(outline - root).T).max() == pytest.approx(LENGTH, abs=1e-9)


def test_path_is_marked_where_the_nozzle_is_open() -> None:
    columns = turn()
    (axes,) = figures.draw_tip_path(columns).axes
    opened = np.isfinite(data(axes, "tip, open")[0][:-1])
    assert np.array_equal(opened, columns["theta1_deg"] > 0)


def test_ground_path_is_there_if_the_machine_travels() -> None:
    columns = turn(-160.0)
    machine, ground = figures.draw_tip_path(columns).axes
    assert np.array_equal(data(ground, "tip, closed"), [columns["tip_x_mm"], columns["tip_y_mm"]])
    assert np.allclose(data(machine, "tip, closed")[0][:-1], turn()["tip_x_mm"], atol=1e-9, rtol=0)
    assert ground.get_aspect() == 1


def test_soil_and_the_path_before_are_drawn_where_there_are_any() -> None:
    old = {**turn(), "tip_y_mm": turn()["tip_y_mm"] - 7}
    (axes,) = figures.draw_tip_path(turn(), old, -300.0).axes
    assert np.array_equal(data(axes, "tip, before")[1][:-1], old["tip_y_mm"])
    assert set(data(axes, "soil")[1]) == {-300.0}
    (plain,) = figures.draw_tip_path(turn()).axes
    assert not {"soil", "tip, before"} & {line.get_label() for line in plain.get_lines()}


def test_pitch_curves_are_drawn_where_they_are() -> None:
    gearing = mesh()
    whole_axes, near_axes = figures.draw_pitch_curves(gearing).axes
    for axes in (whole_axes, near_axes):
        assert axes.get_aspect() == 1
        for curve in gearing.curves:
            assert np.array_equal(data(axes, curve.name), curve.points)
    other = [
        np.asarray(line.get_xydata()).T
        for line in whole_axes.get_lines()
        if line.get_gid() == "side 2"
    ]
    assert all(np.array_equal(a, -b.points) for a, b in zip(other, gearing.curves[1:], strict=True))
    named = [text.get_text() for text in near_axes.texts]
    assert set(named) == {"O", "A1", "B1", "P", "Q", "sun", "gear 5", "gear 6", "planet gear"}


# --- search
# ----------------------------------------------------------------------------------------
