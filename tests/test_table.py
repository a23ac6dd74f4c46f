"""Every capability on every machine: each cell compares a number of a command with another route to
it.

The rows are what the commands do with a machine, the columns the built-in machines and the
statements of docs/examples. What a machine cannot have is refused, for a reason that stands in
REFUSED.
"""

from __future__ import annotations

import csv
import json
import tomllib
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image, ImageSequence
from scipy.optimize import minimize_scalar

from derive.emit.folder import built_in, render_texts
from derive.papers.clutch import model as clutch
from derive.papers.mapping import model as mapping
from derive.papers.pickup import model as pickup
from derive.papers.planting import derivation
from planter import menu
from planter.cli.app import build_application
from planter.engine.machine import Machine, load_machine
from planter.files import examples, units
from planter.kernels import Array
from planter.mechanism import file as mechanism_file
from planter.mechanism import labelled
from planter.mechanism.dynamics import Dynamics
from planter.report.scene import Scene
from planter.report.sheet import Length
from planter.report.subject import Movable, Shown, open_machine
from tests.planter.exports.exported import Library
from tests.support import own
from tests.support.cli import answer, run
from tests.support.reference import evaluate
from tests.support.units import quick_libraries

SAMPLES = 24
ANGLE = 50.0
"""Where single values are compared [deg]."""


@dataclass(frozen=True)
class Column:
    """A machine, a quantity of it, a value of its file that moves the quantity, and by how much of
    itself.
    """

    name: str
    quantity: str
    value: str
    share: float = 0.05

    @property
    def source(self) -> str:
        return str(own.generated(self.name) / f"{self.name}.toml") if self.is_own else self.name

    @property
    def is_own(self) -> bool:
        return (own.EXAMPLES / f"{self.name}.py").is_file()

    def machine(self, **changes: float) -> Machine:
        return load_machine(self.source, {self.value: changes["to"]} if changes else {})

    @property
    def number(self) -> float:
        """The value, in the unit of the file."""
        machine = self.machine()
        index = machine.find_index(self.value)
        return float(machine.data[index]) / machine.values[index].factor

    @property
    def ends(self) -> tuple[float, float]:
        return self.number * (1 - self.share), self.number * (1 + self.share)

    @property
    def key(self) -> str:
        return self.machine().find_quantity(self.quantity).key

    def angles(self, count: int = SAMPLES) -> Array:
        """So many even steps of a cycle [rad]."""
        return self.machine().turn * np.arange(count) / count

    def rows(self, phi: Array | None = None, to: float | None = None) -> Array:
        """The quantity (n,) at angles [rad] by the other route, with the value set."""
        machine = self.machine() if to is None else self.machine(to=to)
        return evaluate(machine, self.quantity, self.angles() if phi is None else phi)

    def rms(self, to: float) -> float:
        return float(np.sqrt(np.mean(self.rows(to=to) ** 2)))


OF_A_DEVICE = ("wang2017", "compact")
"""Planting devices, which have families of gears, stages and a model as printed."""
COLUMNS = {
    column.name: column
    for column in (
        Column("wang2017", "M_L", "design.m31", 0.01),
        Column("compact", "F_E", "design.alpha3_deg"),
        Column("slider_crank", "M_in", "values.r_mm"),
        Column("transplanting_arm", "M_in", "values.k_N_m"),
        Column("cam_follower", "M_in", "values.h_mm"),
        Column("planetary_train", "M_in", "values.k"),
        Column("elliptic_gears", "W", "values.k"),
        Column("yu2023", "x_S", "bars.L1_mm"),
        Column("sun2019-corrected", "X", "pose[1].x_mm", 0.005),
        Column("shi2021", "M_link", "sleeve.engaging_force_N"),
    )
}


@dataclass(frozen=True)
class FreeColumn(Column):
    """A machine that no angle drives, whose quantity is a coordinate, and a time [s]."""

    time: float = 0.1

    @property
    def measure(self) -> str:
        return f"{self.quantity} at {self.time!r} s"

    def places(self, times: Array, to: float | None = None) -> Array:
        """The coordinate (n,) at times [s] by another integration, in its display unit."""
        mechanism = mechanism_file.load(self.source, {} if to is None else {self.value: to})
        dynamics = Dynamics(mechanism)
        states = dynamics.run(times, 1e-11, dynamics.find_start()).states
        factor = self.machine().find_quantity(self.quantity).factor
        return np.asarray(states[dynamics.names.index(self.quantity)] / factor)

    def place(self, to: float | None = None) -> float:
        return float(self.places(np.array([0.0, self.time]), to)[1])

    def slope(self, step: float = 1e-4) -> float:
        """Its derivative by the value of the file."""
        ends = (self.number * (1 + share * step) for share in (-1, 1))
        below, above = map(self.place, ends)
        return (above - below) / (2 * step * self.number)


FREE = {
    column.name: column
    for column in (
        FreeColumn("manipulator", "elbow", "values.k_2_Nm", time=0.4),
        FreeColumn("andrews", "beta", "values.mom_Nm", time=0.01),
        FreeColumn("whipple", "rear_spin", "values.v_m_s", time=0.3),
    )
}
"""Statements that no angle drives: what needs a turn is refused them cell by cell."""
NOT_COLUMNS = {
    "wang2017-wide": "wang2017 in wider bounds",
    "sun2019": "a second pose of sun2019-corrected, as printed",
    "slider_crank_paper": "a paper on slider_crank",
    **dict.fromkeys(
        own.LIBRARY,
        "a machine of the library: another statement of the same kinds, tested by itself",
    ),
}
Check = Callable[[Column, Path], None]
CELLS: dict[str, Check] = {}
COMMANDS: dict[str, set[str]] = {}
"""Names of the commands that a row covers."""


def row(*commands: str) -> Callable[[Check], Check]:
    def add(check: Check) -> Check:
        name = check.__name__.removeprefix("check_")
        CELLS[name], COMMANDS[name] = check, set(commands)
        return check

    return add


@cache
def command(*words: str) -> Any:
    """The answer of a command, once."""
    return answer(*words)


def close(actual: object, expected: object, rtol: float = 1e-9) -> None:
    """Compare, to a share of the largest number."""
    expected = np.asarray(expected, dtype=float)
    np.testing.assert_allclose(
        np.asarray(actual, dtype=float),
        expected,
        rtol=0,
        atol=rtol * max(np.abs(expected).max(), 1e-9),
    )


@row("simulate", "turn")
def check_simulate(column: Column, folder: Path) -> None:
    (at,) = command("simulate", column.source, "--samples", str(SAMPLES), "--at", str(ANGLE))["at"]
    close(at[column.key], column.rows(np.radians([ANGLE]))[0])


@row("simulate")
def check_summary(column: Column, folder: Path) -> None:
    designer = command("simulate", column.source, "--samples", str(SAMPLES), "--at", str(ANGLE))[
        "designer"
    ]
    (entry,) = (entry for entry in designer["peaks"] if entry["name"] == column.quantity)
    peak, place = entry["max"], entry["max_phi_deg"]
    nearby = np.radians(place + np.append(np.linspace(-2, 2, 81), [-1e-7, 1e-7]))
    close(peak, column.rows(nearby).max(), 1e-5)
    assert column.rows().max() <= peak * (1 + 1e-9) + 1e-9


@row("diff")
def check_difference(column: Column, folder: Path) -> None:
    result = command("diff", column.source, column.source)
    assert result["values"] == []
    (entry,) = [entry for entry in result["results"] if entry["name"] == f"max {column.quantity}"]
    close(entry["values"][0], column.rows(column.angles(1440)).max(), 1e-3)
    assert entry["difference"] == [0.0]


@row("sensitivity")
def check_sensitivity(column: Column, folder: Path) -> None:
    result = command(
        f"sensitivity {column.source} --all --samples {SAMPLES} --least 'rms {column.quantity}'"
    )
    names = [name for name in result["gradient"] if column.value.endswith(name)]
    step = 1e-4 * column.number
    slope = (column.rms(column.number + step) - column.rms(column.number - step)) / (2 * step)
    close(result["objective"], column.rms(column.number))
    close(result["gradient"][names[0]], slope, 1e-5)


def optimum(column: Column, *more: str) -> Any:
    low, high = column.ends
    words = f"--samples {SAMPLES} --method ipopt --starts 2 --least 'rms {column.quantity}'"
    vary = f"--vary {column.value}={low!r}:{high!r}"
    return command(f"optimise {column.source} {words} {vary}", *more)


@row("optimise")
def check_optimise(column: Column, folder: Path) -> None:
    result = optimum(column)
    (x,) = result["design"].values()
    minimum = minimize_scalar(
        column.rms, bounds=column.ends, method="bounded", options={"maxiter": 25}
    )
    best = min(minimum.fun, *map(column.rms, column.ends))
    close(result["objective"], column.rms(x))
    assert result["objective"] <= best * (1 + 1e-6)


@row("optimise")
def check_limit(column: Column, folder: Path) -> None:
    """A limit half-way between the largest values at both ends."""
    peaks = [float(column.rows(to=end).max()) for end in column.ends]
    limit = sum(peaks) / 2
    result = optimum(column, "--hold", f"max {column.quantity} <= {limit!r}")
    (x,) = result["design"].values()
    assert result["met"]
    assert column.rows(to=x).max() <= limit + 1e-6 * abs(limit)
    assert result["objective"] >= optimum(column)["objective"] * (1 - 1e-9)


@row("optimise")
def check_certificate(column: Column, folder: Path) -> None:
    result = optimum(column)
    certificate, (x,) = result["certificate"], result["design"].values()
    low, high = column.ends
    at = {"lower": abs(x - low), "upper": abs(x - high)}
    binding = {side for side, gap in at.items() if gap < 1e-6 * (high - low)}
    assert {active["side"] for active in certificate["active_bounds"]} == binding
    assert certificate["kkt_residual"] < 1e-6
    assert (certificate["starts"], certificate["agreeing_starts"] >= 1) == (2, True)


@row("optimise")
def check_prove(column: Column, folder: Path) -> None:
    if column.name in OF_A_DEVICE:
        words = f"--samples {SAMPLES} --method ipopt --starts 1 --prove --prove-seconds 4"
        proof = answer(f"optimise {column.source} {words}")["proof"]
        bounds = [_objective(column, x) for x in np.linspace(*column.ends, 5).tolist()]
    else:
        proof = optimum(column, "--prove", "--prove-seconds", "4")["proof"]
        bounds = [column.rms(x) for x in np.linspace(*column.ends, 9)]
    assert proof["lower_bound"] is not None
    assert proof["lower_bound"] <= min(bounds)
    assert proof["lower_bound"] > 0 or column.name in OF_A_DEVICE, "ten parameters take longer"


def _objective(column: Column, to: float) -> float:
    """The sum of a device's file by the other route."""
    machine = column.machine(to=to)
    forces = evaluate(machine, "F_support", 2 * np.pi * np.arange(SAMPLES) / SAMPLES)
    kinds = {"range": np.ptp, "variance": np.var, "std": np.std}
    return float(sum(measure.weight * kinds[measure.kind](forces) for measure in machine.least))


@row("optimise")
def check_whole_teeth(column: Column, folder: Path) -> None:
    """The pitch curves of the optimum are so many pitches long: its gears need no other size."""
    if column.name in OF_A_DEVICE:
        out = folder / "optimum"
        words = "--module 1 --method ipopt --starts 1 --samples 90 --out"
        teeth = answer(f"optimise {column.source} {words}", str(out))["teeth"]["stages"]
        stages = answer("gears", str(out / "optimum.toml"), "--module", "1")["stages"]
        assert [stage["z"][0] for stage in stages] == [stage["z"] for stage in teeth]
        close([stage["scale"] for stage in stages], [1.0, 1.0], 1e-7)
    else:
        result = command(
            "gears", column.source, *(() if column.name == "yu2023" else ("--module", "1"))
        )
        pair = result["intermittent"] or result["stages"][0]
        assert np.all(np.asarray(pair["z"]) == np.round(pair["z"]))


@row("calibrate")
def check_calibrate(column: Column, folder: Path) -> None:
    truth = column.number + 0.4 * (column.ends[1] - column.number)
    degrees = np.arange(0.0, 360.0, 6.0)
    curve = column.rows(np.radians(degrees), to=truth)
    unit = units.display_unit(column.key)
    lines = [f"{a!r},{v!r}" for a, v in zip(degrees.tolist(), curve.tolist(), strict=True)]
    path = folder / "measured.csv"
    path.write_text(
        "\n".join([f"angle [deg],curve [{unit or '1'}]", *lines]) + "\n", encoding="utf-8"
    )
    low, high = column.ends
    words = f"--data {path} --column curve --angle angle --quantity {column.key}"
    words += " --model exact" if column.name in OF_A_DEVICE else ""
    fit = f"--fit {column.value}={low!r}:{high!r}"
    result = answer(f"calibrate {column.source} {words} {fit}")
    (fitted,) = (entry for entry in result["fitted"] if entry["name"] == column.value)
    close(fitted["value"], truth, 1e-5)


def output(column: Column) -> str:
    suffix = units.unit_suffix(column.key)
    return f"{column.key.removesuffix(suffix)}_max{suffix}"


@row("sweep")
def check_sweep(column: Column, folder: Path) -> None:
    plan, values = folder / "plan.toml", [column.ends[0], column.number, column.ends[1]]
    lines = [
        f"machine = {json.dumps(column.source)}",
        f'outputs = ["{output(column)}"]',
        "[inputs]",
    ]
    plan.write_text("\n".join([*lines, f'"{column.value}" = {values!r}']) + "\n", encoding="utf-8")
    answer(f"sweep {plan} --workers 1 --out", str(folder / "run"))
    with (folder / "run" / "rows.csv").open(encoding="utf-8") as file:
        rows = [line for line in csv.reader(file) if line and line[0][:1] in "-0123456789"]
    phi = column.angles(20_000)  # rows have true extremes
    close(
        [float(line[-1]) for line in rows],
        [column.rows(phi, to=x).max() for x in values],
        rtol=1e-6,
    )


def tolerances(column: Column, folder: Path) -> Any:
    path = folder / "tolerances.toml"
    path.write_text(
        f'[tolerances]\n"{column.value}" = {{ plus_minus = {0.001 * column.number!r} }}\n',
        encoding="utf-8",
    )
    words = f"--samples 200 --indices 32 --no-robust --workers 1 --tolerances {path}"
    return answer(f"tolerance {column.source} {words} --output", output(column))


@row("tolerance")
def check_tolerance(column: Column, folder: Path) -> None:
    """To first order by differences, as drawn, and the indices of a single input: one."""
    result = tolerances(column, folder)
    (band,), ((indices,),) = (
        result["outputs"].values(),
        (parameter.values() for parameter in result["sobol"].values()),
    )
    phi = column.angles(column.machine().samples)
    step = 1e-4 * column.number
    slope = (
        column.rows(phi, to=column.number + step).max()
        - column.rows(phi, to=column.number - step).max()
    ) / (2 * step)
    first_order = abs(slope) * result["inputs"][0]["std"]
    assert band["first_order_std"] == pytest.approx(first_order, rel=1e-4)
    assert band["std"] == pytest.approx(first_order, rel=0.2)
    assert abs(indices["first"] - 1) <= indices["first_error"]


@row("tolerance")
def check_robust(column: Column, folder: Path) -> None:
    """With less deviation than the best design without tolerances; what that has, by the other
    route.
    """
    plan = folder / "tolerances.toml"
    plan.write_text(
        f'[tolerances]\n"{column.value}" = {{ plus_minus = {0.001 * column.number!r} }}\n',
        encoding="utf-8",
    )
    (low, high), sum_ = column.ends, f"rms {column.quantity}"
    words = f"--samples 100 --indices 0 --workers 1 --sigmas 1 --tolerances {plan}"
    if column.name not in OF_A_DEVICE:
        words += f" --output {output(column)} --least '{sum_}'"
        words += f" --vary {column.value}={low!r}:{high!r}"
    result = answer(f"tolerance {column.source} {words}")["robust"]
    assert result["objective"] == pytest.approx(result["mean"] + result["std"], rel=1e-12)
    assert result["objective"] <= result["own_objective"] * (1 + 1e-9)


@row("drive")
def check_drive(column: Column, folder: Path) -> None:
    """With a heavy flywheel the motor's line at the mean torque gives the speed."""
    speed = float(60 / (2 * np.pi) * column.machine().data[column.machine().speed])
    stall, idle = 500.0, 1.1 * speed
    words = f"--stall-Nm {stall} --idle-rpm {idle!r} --flywheel-kgm2 1e3 --samples 360"
    result = answer(f"drive {column.source} {words}")
    mean = result["motor_work_J"] / (2 * np.pi)
    assert result["speed"]["mean_rpm"] == pytest.approx(idle * (1 - mean / stall), rel=1e-5)
    assert result["speed"]["fluctuation"] < 1e-3
    energy = 1e3 * (speed * np.pi / 30) ** 2
    assert result["motor_work_J"] == pytest.approx(result["friction_work_J"], abs=1e-9 * energy)


@row("compare")
def check_families(column: Column, folder: Path) -> None:
    """The device in the paper's narrow box, which is compared with, is one that `simulate`
    knows.
    """
    result = answer(f"compare {column.source} --starts 1 --pair limacon+limacon")
    narrow, (device,) = result["narrow"], result["devices"]
    design = [
        word
        for key, value in narrow["design"].items()
        for word in ("--set", f"design.{key}={value!r}")
    ]
    close(
        answer("simulate", column.source, *design)["refined"]["objective"],
        narrow["objective"],
        1e-8,
    )
    assert device["objective"] < narrow["objective"]


@row("explain")
def check_explain(column: Column, folder: Path) -> None:
    result, machine = command("explain", column.source), column.machine()
    entries = {
        entry.get("key", entry["name"]): entry
        for entry in (*result.get("values", ()), *result.get("symbols", ()))
    }
    values = [value for value in machine.values if value.path in entries]
    assert entries
    assert len(values) > 2 or not column.is_own
    for value in values:
        assert entries[value.path]["unit"] in (value.unit, units.display_unit(value.path))
        if "value" in entries[value.path]:
            close(
                entries[value.path]["value"] * value.factor,
                machine.data[machine.find_index(value.path)],
            )


@row("explain")
def check_drawing(column: Column, folder: Path) -> None:
    files = answer("explain", column.source, "--out", str(folder / "drawn"))["files"]
    assert any(file.endswith(".svg") for file in files)
    if column.is_own:
        (sheet,), machine = labelled.draw(column.source, {}), column.machine()
        numbers = {value.name: value for value in machine.values}
        for mark in sheet.marks:
            if isinstance(mark, Length):
                close(mark.size, 1e3 * machine.data[machine.values.index(numbers[mark.names[0]])])
        assert sheet.names


@row("export")
def check_c(column: Column, folder: Path) -> None:
    files = tuple(map(Path, answer("export c", column.source, "--out", str(folder / "c"))["files"]))
    library = Library(files)
    status, values = library.quantities(column.angles())
    assert status == 0
    close(
        values[library.names.index(column.quantity)]
        / column.machine().find_quantity(column.quantity).factor,
        column.rows(),
    )


def _unit(column: Column, folder: Path, version: str) -> None:
    fmpy = pytest.importorskip("fmpy")
    unit = folder / "unit.fmu"
    answer(f"export fmu {column.source} --fmi {version} --out {unit}")
    speed = float(column.machine().data[column.machine().speed])
    period = 2 * np.pi / abs(speed)
    name = column.quantity if column.name != "compact" else f"side1.{column.quantity}"
    output = fmpy.simulate_fmu(
        str(unit), output=["phi", name], stop_time=period, output_interval=period / 12
    )
    machine = column.machine()
    close(output[name] / machine.find_quantity(column.quantity).factor, column.rows(output["phi"]))


@row("export")
def check_fmu_2(column: Column, folder: Path) -> None:
    _unit(column, folder, "2.0")


@row("export")
def check_fmu_3(column: Column, folder: Path) -> None:
    _unit(column, folder, "3.0")


@row("export")
def check_motion(column: Column, folder: Path) -> None:
    answer(f"export motion {column.source} --samples {SAMPLES} --out {folder}")
    with (folder / "motion.csv").open(encoding="utf-8") as file:
        lines = [line for line in csv.reader(file) if not line[0].startswith("#")]
    place = lines[0].index(column.key)
    angles = np.radians([float(line[1]) for line in lines[1:]])
    close([float(line[place]) for line in lines[1:]], column.rows(angles))


SYSTEMS = {
    "wang2017": derivation.build_exact_system,
    "compact": derivation.build_exact_system,
    "yu2023": pickup.build_pickup_system,
    "sun2019-corrected": mapping.build_mapping_system,
    "shi2021": clutch.build_clutch_system,
}


def _written(column: Column, folder: Path, language: str) -> str:
    if column.is_own:
        statement = own.EXAMPLES / f"{column.name}.py"
        answer(f"derive {statement} --target {language} --out {folder}")
        return "\n".join(
            file.read_text(encoding="utf-8") for file in (folder / language).rglob("*.*")
        )
    target = next(target for target in built_in() if target.name == language)
    return "\n".join(render_texts([SYSTEMS[column.name]()], [], [target]).values())


@row("derive")
def check_matlab(column: Column, folder: Path) -> None:
    """All results are there; their numbers are tested where Octave is (tests/derive/emit)."""
    text = _written(column, folder, "matlab")
    names = _names(column)
    assert len(names) > 1
    assert all(name in text for name in names)


@row("derive")
def check_latex(column: Column, folder: Path) -> None:
    text = _written(column, folder, "latex")
    names = [name.replace("_", r"\_") for name in _names(column)]
    assert sum(name in text for name in names) > 0.9 * len(names)


def _names(column: Column) -> list[str]:
    """Names of what the statement's functions give."""
    if column.is_own:
        sidecar = json.loads(
            (own.generated(column.name) / f"{column.name}.json").read_text(encoding="utf-8")
        )
        vectors = sidecar["vectors"]
        return [entry["name"] for entry in vectors.get("outputs", vectors.get("states", ()))]
    system = SYSTEMS[column.name]()
    outputs = system.lane.outputs if system.lane else system.closed_forms[0].outputs
    return [quantity.name for quantity in outputs]


@row("animate")
def check_animate(column: Column, folder: Path) -> None:
    answer(f"animate {column.source} --seconds 2 --out", str(folder / "a.gif"))
    with Image.open(folder / "a.gif") as image:
        frames = [frame.info["duration"] for frame in ImageSequence.Iterator(image)]
    assert len(frames) > 10
    assert 1e-3 * sum(frames) == pytest.approx(2, rel=0.1)


@row("studio")
def check_studio(column: Column, folder: Path) -> None:
    """A hand on a value moves the drawing, which lasts as long as a turn of the drive."""
    subject, machine = open_machine(column.source), column.machine()
    path = (
        subject.controls[0].path if column.name == "shi2021" else column.value
    )  # a force moves nothing
    share = column.ends[1] / column.number
    scene = check_drawing_moves(subject, path, share)
    if column.name not in (
        "sun2019-corrected",
        "shi2021",
    ):  # poses and a shift are shown in a time of their own
        assert scene.seconds == pytest.approx(
            2 * np.pi / abs(machine.data[machine.speed]), rel=1e-9
        )


def check_drawing_moves(subject: Shown, path: str, share: float) -> Scene:
    """Return the scene of a machine, after a look at that with a value times a share."""
    values = {control.path: control.value for control in subject.controls}
    scene, moved = (
        subject.scenes(values | {path: values[path] * factor}, subject.models[0])[0]
        for factor in (1.0, share)
    )
    pairs = [
        *zip(scene.curves, moved.curves, strict=True),
        *zip(scene.points, moved.points, strict=True),
    ]
    assert any(repr(before) != repr(after) for before, after in pairs)
    return scene


@row("studio")
def check_page(column: Column, folder: Path) -> None:
    """What a page computes by itself, with the value changed."""
    code, _, err = run("studio", column.source, "--static", str(folder / "page.html"))
    if "planter[compiler] is not installed" in err:
        pytest.skip("needs ziglang")
    assert code == 0, err
    subject = open_machine(column.source)
    assert isinstance(subject, Movable)
    portable = subject.portable(subject.models[0])
    numbers = portable.at({column.value: column.ends[1]}, portable.seen)
    singles = dict(zip(portable.singles, np.ravel(numbers["singles"]), strict=True))
    speed = column.machine().data[column.machine().speed]
    close(singles["seconds"], 2 * np.pi / abs(speed))
    if f"largest {column.key}" in singles:
        phi = column.angles(column.machine().samples)
        close(singles[f"largest {column.key}"], column.rows(phi, to=column.ends[1]).max())


@row("gears")
def check_gears(column: Column, folder: Path) -> None:
    """Pitch curves are whole pitches long; a pair's radii add up to the distance of its axes."""
    result = command(
        "gears", column.source, *(() if column.name == "yu2023" else ("--module", "1"))
    )
    if result["intermittent"]:
        cut = result["intermittent"]
        close(cut["pitches"] * np.pi * cut["module_mm"], cut["toothed_arc_mm"])
    for stage in result["stages"]:
        close(stage["perimeter_mm"], np.pi * stage["module_mm"] * np.array(stage["z"]), 1e-7)


@row("cam")
def check_cam(column: Column, folder: Path) -> None:
    result = command(f"cam {column.source} --roller-mm 6")
    if column.is_own:
        phi = np.radians(result["pressure_angle_deg"]["at_deg"])
        step = 1e-5
        lift = evaluate(column.machine(), "s", np.array([phi - step, phi, phi + step])) * 1e-3
        base = column.machine().data[column.machine().find_index("values.y_0_mm")]
        slope = (lift[2] - lift[0]) / (2 * step)
        close(
            result["pressure_angle_deg"]["max"],
            np.degrees(np.arctan(abs(slope) / (base + lift[1]))),
            1e-6,
        )
    else:
        designer = command(f"simulate {column.source} --samples {SAMPLES} --at {ANGLE}")["designer"]
        close(result["pressure_angle_deg"]["max"], designer["cam_pressure_angle_max_deg"])


@row("simulate")
def check_report(column: Column, folder: Path) -> None:
    out = folder / "report"
    result = answer(f"simulate {column.source} --samples {SAMPLES} --at {ANGLE} --out {out}")
    written = json.loads((out / "summary.json").read_text(encoding="utf-8"))
    assert (
        written["at"]
        == result["at"]
        == command(f"simulate {column.source} --samples 24 --at 50.0")["at"]
    )
    assert "<svg" in (out / "report.html").read_text(encoding="utf-8")


OF_PAPERS = ("yu2023", "sun2019-corrected", "shi2021")
LINKAGES = ("slider_crank", "transplanting_arm", "sun2019-corrected", "shi2021")
REASONS = (
    (
        "families",
        "its gears are of no family, or it has none",
        [name for name in COLUMNS if name not in OF_A_DEVICE],
    ),
    ("gears", "no two bodies of it mesh", [*LINKAGES, "cam_follower"]),
    ("whole_teeth", "no stages of gears", [*LINKAGES, "cam_follower"]),
    ("cam", "no cam moves a roller", [*LINKAGES, "planetary_train", "elliptic_gears", "yu2023"]),
    (
        "drive",
        "motion alone is stated: without masses no motor has work",
        ["elliptic_gears", "yu2023", "sun2019-corrected"],
    ),
    (
        "drive",
        "no inertia of its linkage is given, so that its torque is that of a constant speed",
        ["shi2021"],
    ),
    ("page", "its law or its dyads are fitted in Python, which a page does not run", OF_PAPERS),
    ("prove", "its functions are composed of fits that have no enclosure yet", OF_PAPERS),
)
REFUSED = {(name, column): reason for name, reason, columns in REASONS for column in columns}
"""Why cells are empty."""
MOST_REFUSED = 0.15
FREE_CELLS: dict[str, Callable[[FreeColumn, Path], None]] = {}


def free_cell(check: Callable[[FreeColumn, Path], None]) -> Callable[[FreeColumn, Path], None]:
    FREE_CELLS[check.__name__.removeprefix("check_free_")] = check
    return check


@free_cell
def check_free_explain(column: FreeColumn, folder: Path) -> None:
    entries = answer("explain", column.source)["values"]
    values = tomllib.loads(Path(column.source).read_text(encoding="utf-8"))["values"]
    assert {entry["key"].removeprefix("values."): entry["value"] for entry in entries} == values


@free_cell
def check_free_matlab(column: FreeColumn, folder: Path) -> None:
    check_matlab(column, folder)


@free_cell
def check_free_latex(column: FreeColumn, folder: Path) -> None:
    check_latex(column, folder)


@free_cell
def check_free_simulate(column: FreeColumn, folder: Path) -> None:
    quantities = answer(f"simulate {column.source} --until {column.time!r}")["quantities"]
    close(quantities[column.key]["last"], column.place(), 1e-6)


@free_cell
def check_free_sensitivity(column: FreeColumn, folder: Path) -> None:
    result = answer(f"sensitivity {column.source} --all --least '{column.measure}'")
    names = [name for name in result["gradient"] if column.value.endswith(name)]
    close(result["objective"], column.place(), 1e-7)
    close(result["gradient"][names[0]], column.slope(), 1e-4)


@free_cell
def check_free_optimise(column: FreeColumn, folder: Path) -> None:
    """The value at which the coordinate is half-way between those at both ends."""
    ends = [column.place(end) for end in column.ends]
    limit, (low, high) = sum(ends) / 2, column.ends
    words = f"--vary {column.value}={low!r}:{high!r} --starts 1 --least '{column.measure}'"
    result = answer(f"optimise {column.source} {words} --hold", f"{column.measure} >= {limit!r}")
    close(result["objective"], limit, 1e-6)
    (x,) = result["design"].values()
    close(column.place(x), limit, 1e-6)


@free_cell
def check_free_sweep(column: FreeColumn, folder: Path) -> None:
    plan, values = folder / "plan.toml", [column.ends[0], column.number]
    lines = [f"machine = {json.dumps(column.source)}", f'outputs = ["{column.measure}"]']
    lines += ["[inputs]", f'"{column.value}" = {values!r}']
    plan.write_text("\n".join(lines) + "\n", encoding="utf-8")
    answer(f"sweep {plan} --workers 1 --out", str(folder / "run"))
    with (folder / "run" / "rows.csv").open(encoding="utf-8") as file:
        rows = [line for line in csv.reader(file) if line[0][:1] in "-0123456789"]
    close([float(line[-1]) for line in rows], [column.place(x) for x in values], 1e-7)


@free_cell
def check_free_tolerance(column: FreeColumn, folder: Path) -> None:
    path = folder / "tolerances.toml"
    width = 0.001 * column.number
    path.write_text(f'[tolerances]\n"{column.value}" = {{ plus_minus = {width!r} }}\n', "utf-8")
    words = f"--samples 100 --indices 0 --halved 0 --no-robust --workers 1 --tolerances {path}"
    result = answer(f"tolerance {column.source} {words} --output", column.measure)
    (band,), (spread,) = result["outputs"].values(), result["inputs"]
    first_order = abs(column.slope()) * spread["std"]
    assert band["first_order_std"] == pytest.approx(first_order, rel=1e-3)
    assert band["std"] == pytest.approx(first_order, rel=0.3)


@free_cell
def check_free_calibrate(column: FreeColumn, folder: Path) -> None:
    (low, high), path = column.ends, folder / "measured.csv"
    truth, times = column.number + 0.4 * (high - column.number), np.linspace(0, column.time, 40)
    unit = units.display_unit(column.key)
    pairs = zip(times.tolist(), column.places(times, truth).tolist(), strict=True)
    lines = [f"time [s],curve [{unit}]", *(f"{t!r},{v!r}" for t, v in pairs)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    words = f"--data {path} --column curve --time time --quantity {column.key}"
    result = answer(f"calibrate {column.source} {words} --fit {column.value}={low!r}:{high!r}")
    close(result["fitted"][0]["value"], truth, 1e-5)


@free_cell
def check_free_difference(column: FreeColumn, folder: Path) -> None:
    result = answer(f"diff {column.source} {column.source} --until {column.time!r}")
    assert result["values"] == []
    name = f"max {column.quantity} over 0..{column.time:g} s"
    (entry,) = [entry for entry in result["results"] if entry["name"] == name]
    close(entry["values"][0], column.places(np.linspace(0, column.time, 2001)).max(), 1e-4)


@free_cell
def check_free_animate(column: FreeColumn, folder: Path) -> None:
    check_animate(column, folder)


@free_cell
def check_free_studio(column: FreeColumn, folder: Path) -> None:
    """A hand on a value moves the drawing, which lasts as long as the motion."""
    subject = open_machine(column.source, {"motion.until_s": column.time})
    scene = check_drawing_moves(subject, column.value, column.ends[1] / column.number)
    assert scene.seconds == column.time


FREE_REFUSED = {
    "drive": ("a motor turns a drive", "--stall-Nm 6 --idle-rpm 42 --flywheel-kgm2 1"),
    "cam": ("no drive turns a cam", "--roller-mm 6"),
    "gears": ("teeth of a free motion are stated as forces or rows", "--module 1"),
    "compare": ("families of gears drive a device", "--starts 1"),
    "studio": ("a page without a server has no integrator", "--static {folder}/page.html"),
}
"""Why what moves freely has no such cell, by command, and words with which the command says so."""


def _cells() -> list[Any]:
    """All cells; those of a diagonal, one for each row, are tried by every run of the tests."""
    cells = [(name, column) for name in CELLS for column in COLUMNS]
    excluded = {(name, list(COLUMNS)[(k + 1) % len(COLUMNS)]) for k, name in enumerate(CELLS)}
    return [
        pytest.param(*cell, marks=() if cell in excluded else pytest.mark.long) for cell in cells
    ]


@pytest.fixture(autouse=True)
def _quick() -> Any:
    """Libraries of units for this system alone, compiled without passes."""
    with quick_libraries():
        yield


@pytest.mark.usefixtures("blank_figures")
@pytest.mark.parametrize(("capability", "machine"), _cells())
def test_cell_numbers_equal_independent_route(
    capability: str, machine: str, tmp_path: Path
) -> None:
    check, column = CELLS[capability], COLUMNS[machine]
    if (capability, machine) in REFUSED:
        with pytest.raises(AssertionError, match="planter: ") as caught:
            check(column, tmp_path)
        assert "allowed here" not in str(caught.value), "the reason is no schema of another machine"
    else:
        check(column, tmp_path)


@pytest.mark.long
@pytest.mark.usefixtures("blank_figures")
@pytest.mark.parametrize("machine", FREE)
@pytest.mark.parametrize("capability", FREE_CELLS)
def test_free_cell_numbers_equal_independent_route(
    capability: str, machine: str, tmp_path: Path
) -> None:
    FREE_CELLS[capability](FREE[machine], tmp_path)


@pytest.mark.long
@pytest.mark.parametrize("command", FREE_REFUSED)
def test_what_needs_a_drive_is_refused_to_free_motion(command: str, tmp_path: Path) -> None:
    words = FREE_REFUSED[command][1].format(folder=tmp_path)
    code, _, err = run(*f"{command} {FREE['manipulator'].source} {words}".split())
    assert code == 2, err
    assert "allowed here" not in err


def test_refusals_are_few_and_of_cells() -> None:
    assert REFUSED.keys() <= {(name, column) for name in CELLS for column in COLUMNS}
    assert len(REFUSED) <= MOST_REFUSED * len(CELLS) * len(COLUMNS)


def test_every_statement_and_built_in_machine_is_a_column() -> None:
    stated = {path.stem for path in own.EXAMPLES.glob("*.py")}
    shipped = {name.removesuffix(".toml") for name in examples.list_examples(suffix=".toml")}
    assert stated | shipped == COLUMNS.keys() | FREE.keys() | NOT_COLUMNS.keys()


WITHOUT_A_MACHINE = {
    "audit",
    "bench",
    "cite",
    "doctor",
    "example",
    "help",
    "schema",
    "linearise",
    "move",
    "new",
    "pickup",
    "clutch",
    "prove",
    "synthesise",
    "train",
    "validate",
}
"""Commands about papers, installations and files, or about one kind of machine."""


def test_every_command_about_machines_is_in_a_row() -> None:
    app = build_application()
    names = {command.name or command.callback.__name__ for command in app.registered_commands}
    names |= {str(group.name) for group in app.registered_groups} | menu.RENAMED.keys()
    names -= menu.GROUPS.keys()
    assert names - WITHOUT_A_MACHINE == set().union(*COMMANDS.values())


def test_changed_number_is_noticed() -> None:
    with pytest.raises(AssertionError):
        close([1.0, 2.0 + 1e-8], [1.0, 2.0])
