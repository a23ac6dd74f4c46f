"""Figures of sweeps show the computed rows: their ends, their values, and a band only over other
inputs.
"""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import FillBetweenPolyCollection, QuadMesh

from planter.kernels import Array
from planter.rows.points import Axis, Grid, UnitCubePoints, draw_latin, to_axis_table
from planter.rows.sweep_presentation import SweepData, draw_envelope, draw_map

SPEED = {"from": 35, "to": 45, "steps": 61}
MASS = [1.0, 1.1, 1.4]


def draw_sweep(at_random: bool = False, **inputs: Any) -> SweepData:
    """The points of a grid, or 300 at random, over inputs as a plan has them."""
    named = {name: Axis.model_validate(to_axis_table(entry)) for name, entry in inputs.items()}
    axes = list(named.values())
    random = UnitCubePoints(axes, 300, draw_latin(len(axes), 5))
    points = random if at_random else Grid(axes)
    return SweepData(named, points.block(0, points.rows), at_random)


def panels(rows: SweepData, values: Array) -> list[Axes]:
    return [axes for axes in draw_envelope(rows, "out", values).axes if axes.get_visible()]


def bands(axes: Axes) -> list[FillBetweenPolyCollection]:
    return [
        collection
        for collection in axes.collections
        if isinstance(collection, FillBetweenPolyCollection)
    ]


def test_single_input_is_line_through_rows() -> None:
    rows = draw_sweep(speed=SPEED)
    values = rows.points[:, 0] ** 3
    (axes,) = panels(rows, values)
    (line,) = axes.lines
    assert np.array_equal(line.get_xydata(), np.column_stack([rows.points[:, 0], values]))
    assert bands(axes) == []


def test_several_inputs_show_mean_and_extremes() -> None:
    rows = draw_sweep(speed=SPEED, mass=MASS)
    speed, mass = rows.points.T
    first, second = panels(rows, speed * mass)
    at = np.linspace(35, 45, 61)
    assert np.allclose(
        first.lines[0].get_xydata(), np.column_stack([at, at * np.mean(MASS)]), rtol=1e-14
    )
    assert np.allclose(
        second.lines[0].get_xydata(), np.column_stack([MASS, 40 * np.array(MASS)]), rtol=1e-14
    )
    extremes = bands(first)[0].get_datalim(first.transData)
    assert (extremes.x0, extremes.x1) == (35, 45)
    assert np.allclose([extremes.y0, extremes.y1], [35, 45 * 1.4])


def test_missing_result_is_a_gap() -> None:
    rows = draw_sweep(speed=SPEED)
    values = np.where(rows.points[:, 0] == 40, np.nan, 1.0)
    (line,) = panels(rows, values)[0].lines
    assert np.flatnonzero(np.isnan(line.get_ydata())).tolist() == [30]


def test_random_points_are_drawn_one_by_one() -> None:
    rows = draw_sweep(at_random=True, speed={"from": 35, "to": 45}, mass=MASS)
    values = rows.points @ [1.0, 2.0]
    for axes, column in zip(panels(rows, values), rows.points.T, strict=True):
        (line,) = axes.lines
        assert np.array_equal(line.get_xydata(), np.column_stack([column, values]))
    figure = draw_map(rows, "speed", "mass", "out", values)
    assert figure is not None
    assert np.array_equal(figure.axes[0].collections[0].get_array(), values)


def test_map_has_cell_for_every_value() -> None:
    rows = draw_sweep(speed=SPEED, mass=MASS)
    figure = draw_map(rows, "speed", "mass", "out", rows.points[:, 0] * rows.points[:, 1])
    assert figure is not None
    (mesh,) = (
        collection for collection in figure.axes[0].collections if isinstance(collection, QuadMesh)
    )
    assert np.allclose(mesh.get_array(), np.outer(MASS, np.linspace(35, 45, 61)))
