"""Linkages and gear trains of poses as machines of the engine: the room's own numbers, derivatives
by differences.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np
import pytest

from planter.engine.machine import Machine, load_machine
from planter.engine.response import MachineResponse
from planter.engine.rows import MachineRows
from planter.errors import ComputationError, InputError
from planter.numerics.arrays import wrap_angle
from planter.papers.mapping import model
from planter.papers.mapping.curve import load_curve
from planter.papers.mapping.file import PoseFile, load_poses
from planter.papers.mapping.machines import build_linkage, takes
from planter.papers.mapping.synthesis import find_linkages
from planter.papers.mapping.train import Train
from planter.text_files import parse_toml
from tests.planter.papers.mapping.data import CORRECTED
from tests.support.responses import values_of

ANGLES = np.linspace(-3.0, 9.0, 61)


def file_of(poses: Sequence[tuple[float, float, float]], linkage: int | None = None) -> PoseFile:
    rows = [f"[[pose]]\nx_mm = {x}\ny_mm = {y}\nphi_deg = {phi}\n" for x, y, phi in poses]
    points = (
        ""
        if linkage is None
        else (
            f"[points]\nlinkage = {linkage}\nfirst_pose = 1\nfirst_carrier_deg = [0, 90, 180]\n"
            "second_pose = 4\nsecond_carrier_deg = []\n"
        )
    )
    return PoseFile.read(parse_toml("\n".join(rows) + points, "poses"), "poses")


PRINTED = [(235.0, 120.0, 10.0), *CORRECTED[1:]]


@cache
def linkage_machine(number: int) -> Machine:
    return build_linkage(file_of(PRINTED, number))


@pytest.mark.parametrize("number", [1, 2, 4], ids=["double crank", "crank rocker", "another"])
def test_linkage_equals_package_linkage(number: int) -> None:
    linkage = find_linkages(file_of(PRINTED).poses)[1][number - 1]
    bar, values = linkage.bar, values_of(linkage_machine(number), ANGLES)
    phi = bar.arm_angle(ANGLES, np.full(len(ANGLES), linkage.standings[0].assembly))
    tip = bar.tip(ANGLES, phi)
    hinge = model.place_point(np.column_stack([tip.T, phi]), bar.follower.point)
    assert np.abs(wrap_angle(values["phi"] - phi)).max() < 1e-12
    assert np.abs(np.diff(values["phi"])).max() < 3
    np.testing.assert_allclose([values["d1"], values["d2"]], tip, rtol=0, atol=1e-12)
    np.testing.assert_allclose([values["X_f"], values["Y_f"]], hinge.T, rtol=0, atol=1e-12)
    np.testing.assert_allclose(
        values["transmission"], bar.transmission(ANGLES, phi), rtol=0, atol=1e-11
    )


def test_other_poses_give_their_synthesis() -> None:
    machine = load_machine("sun2019-corrected")
    data = machine.data.copy()
    data[3:6] += [0.003, -0.002, np.radians(1)]
    other = [
        (x + 3, y - 2, phi + 1) if k == 1 else (x, y, phi)
        for k, (x, y, phi) in enumerate(CORRECTED)
    ]
    bar = find_linkages(file_of(other).poses)[1][0].bar
    values = values_of(machine, ANGLES, data)
    tip = bar.tip(ANGLES, bar.arm_angle(ANGLES, np.ones(len(ANGLES))))
    np.testing.assert_allclose([values["d1"], values["d2"]], tip, rtol=0, atol=1e-11)


def test_train_turns_arm_by_curve() -> None:
    file, machine = load_poses("sun2019"), load_machine("sun2019")
    train = Train(load_curve("sun2019-curve"), 0.07)
    values, gears = values_of(machine, ANGLES), train.gears(ANGLES)
    np.testing.assert_allclose(values["relative"], train.curve.at(ANGLES), rtol=0, atol=1e-12)
    for name in ("i", "i1", "i2", "r1", "r2", "r3", "r4"):
        np.testing.assert_allclose(values[name], gears[name], rtol=1e-12, err_msg=name)
    slope, first, second = train.curve.slopes(ANGLES)
    kappa = model.curvature(slope, first, second, train.x_s, 0.07)
    np.testing.assert_allclose(
        [values[f"kappa{k}"] for k in (1, 2, 3, 4)],
        kappa,
        rtol=1e-11,
        atol=1e-11 * np.abs(kappa).max(),
    )
    assert file.carrier_dyad is not None
    motion = train.motion(file.carrier_dyad)
    moved = values_of(machine, motion["theta"])
    np.testing.assert_allclose(
        [moved[name] for name in ("d1", "d2", "X", "Y")], motion["places"], atol=1e-12
    )
    np.testing.assert_allclose(values["r1"] + values["r2"], 0.07, rtol=1e-14)


def test_tip_velocity_is_rate_of_position() -> None:
    for machine in (linkage_machine(2), load_machine("sun2019", {"carrier_speed_rpm": 30.0})):
        response, angles = (
            MachineResponse(machine, ["d1", "d2", "v1", "v2"]),
            np.array([0.3, 2.1, 4.4]),
        )
        point = response.at(machine.design)
        values, rates = response.derivatives(point, angles)
        np.testing.assert_allclose(values[2:], machine.data[machine.speed] * rates[:2], rtol=1e-13)


def test_more_than_five_poses_are_passed_as_closely_as_can_be() -> None:
    bar = find_linkages(file_of(PRINTED).poses)[1][1].bar
    theta = np.linspace(2.2, 3.9, 6)
    phi = bar.arm_angle(theta, np.ones(6))
    poses = np.column_stack([1e3 * bar.tip(theta, phi).T, np.degrees(phi)])
    poses[0, 0] += 0.3
    file = file_of([(float(x), float(y), float(angle)) for x, y, angle in poses])
    linkages = find_linkages(file.poses)[1]
    chosen = next(linkage for linkage in linkages if linkage.bar.turns_round)
    expected = chosen.bar.tip(
        ANGLES, chosen.bar.arm_angle(ANGLES, np.full(61, chosen.standings[0].assembly))
    )
    values = values_of(build_linkage(file), ANGLES)
    np.testing.assert_allclose([values["d1"], values["d2"]], expected, atol=1e-6)


def test_rows_without_a_linkage_fail_alone() -> None:
    machine = linkage_machine(2)
    rows = np.tile(machine.data, (3, 1))
    rows[1, 3] += 5.0
    result = MachineRows(machine, ["d1"]).evaluate(rows, lambda block: block.samples.max(axis=1))
    assert np.isnan(result[:, 0]).tolist() == [False, True, False]


def test_poses_without_a_turning_linkage_are_refused() -> None:
    with pytest.raises(InputError, match=r"family of linkages; 5 independent"):
        build_linkage(file_of(PRINTED[:4]))
    with pytest.raises(InputError, match=r"points\.linkage.*deg only; it must be one of 1, 2, 3"):
        build_linkage(file_of(PRINTED, 6))
    with pytest.raises(InputError, match=r"points\.linkage.*from 1 to 6"):
        build_linkage(file_of(PRINTED, 7))


def test_impossible_train_curve_is_refused() -> None:
    with pytest.raises(InputError, match=r"\[curve\] point 17: relative_deg"):
        load_machine("sun2019", {"curve.relative_deg[16]": -340.0})
    with pytest.raises(ComputationError, match="slope of the angle curve reaches zero"):
        load_machine("sun2019", {"curve.relative_deg[5]": -40.0})
    assert takes("sun2019")
    assert not takes("sun2019-curve")
