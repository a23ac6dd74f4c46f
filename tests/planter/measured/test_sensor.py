"""[measurement] of machine files: laws of what a sensor sees, in simulations, fits and
explanations; refusals.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from planter import Simulation, simulate
from planter.engine.machine import Machine
from planter.errors import InputError
from planter.files.document import Document, format_lines
from planter.kernels import Array
from planter.measured.curve import Chosen
from planter.measured.reading import Channel, Measurement
from planter.measured.sensor_curve import SensorCurve, measure_cycle
from planter.measured.sensor_view import Curves, ElasticMount, find_sensor_view
from planter.mechanism.cycle import simulate_machine
from planter.mechanism.file import build_from_table, load
from planter.mechanism.machines import build_machine
from planter.numerics.arrays import TURN
from planter.papers.planting.file import PlantingMachine
from planter.papers.planting.model import Device
from planter.report.subject import Movable, open_machine
from planter.studio.static_page import StaticPageModel, file_template
from tests.support import machines, own
from tests.support.cli import answer, refusal
from tests.support.tables import read_cycle_csv

KNIFE = '''"""A knife drive: a crank turns clockwise and moves a knife bar by a connecting rod."""

from derive import Mechanism, quantities

q = quantities("""
    theta | rad   | angle of the crank
    n     | r/min | speed of the crank, clockwise     | -420
    g     | m/s2  | free fall, across the bar         | 9.81
    a     | mm    | crank                             | 35
    b     | mm    | connecting rod                    | 180
    m_k   | kg    | mass of the knife bar             | 1.2  | 0.8 1.8
    k     | N/m   | stiffness of the spring           | 700
    l_0   | mm    | length of the spring without load | 150
    wall  | mm    | anchor of the spring              | 400
""")
m = Mechanism("knife_drive", q, angle=q.theta, speed=q.n, gravity=q.g, source="a test")
beta, s = m.coordinate("beta", "rad", "angle of the rod"), m.coordinate("s", "m", "place of the knife bar")
crank, rod = m.frame("crank", q.theta), m.frame("rod", beta)
A, slot = m.point("A", m.O, crank, q.a), m.point("slot", m.O, m.world, s)
B = m.point("B", A, rod, q.b)
m.close(B, slot, start={beta: 0, s: q.a + q.b})
wheel, link = m.body("crank", crank), m.body("rod", rod)
bar = m.body("bar", m.world, mass=q.m_k, centroid=slot)
m.pin("O", wheel, m.ground, m.O)
m.pin("A", link, wheel, A)
m.pin("B", bar, link, slot)
m.slide("guide", bar, m.ground, slot)
m.spring("spring", bar, m.ground, (slot, m.point("anchor", m.O, m.world, q.wall)), q.k, q.l_0)
m.motor("M_c", wheel, m.ground, m.O)

SYSTEM = m.system()
'''
WANG = "wang2017"
LEVER = {"drive": "M_L", "lever_mm": 37.2}
PHASE_DEG = 40.0


def build_knife(**measurement: Any) -> Machine:
    """Return the knife drive with a [measurement], or without one."""
    file = own.file(KNIFE, "knife_drive")
    table = file.table() | ({"measurement": measurement} if measurement else {})
    return build_machine(build_from_table(table, "knife.toml", file.place))


def build_wang(**measurement: Any) -> PlantingMachine:
    table = machines.machine(WANG).table() | ({"measurement": measurement} if measurement else {})
    return PlantingMachine.read(table, "wang.toml")


def simulate_wang(samples: int | None = None, **measurement: Any) -> Simulation:
    return simulate(Device(build_wang(**measurement)), samples)


def measure_knife(**measurement: Any) -> tuple[Array, Array]:
    """Return the rigid curve and the signal of the knife drive over its cycle."""
    measured = simulate_machine(build_knife(**measurement)).measured
    assert measured is not None
    return measured.rigid, measured.signal


def write_file(folder: Path, document: Document) -> str:
    path = folder / f"{document.name}.toml"
    path.write_text("\n".join(format_lines(document.written_table(), {})) + "\n", encoding="utf-8")
    return str(path)


def write_data(folder: Path, degrees: Array, values: Array) -> str:
    path = folder / "data.csv"
    rows = (f"{angle:.9g},{value:.12g}\n" for angle, value in zip(degrees, values, strict=True))
    path.write_text("angle [deg],F [N]\n" + "".join(rows), encoding="utf-8")
    return str(path)


def test_lever_of_the_drive_gives_the_published_force() -> None:
    """The measured figures of wang2017 are 171.96 N, 24.93 N and 1033 N2; a lever of 37.2 mm comes
    near.
    """
    result = simulate_wang(**LEVER).result.measurement
    assert result is not None
    assert (result.quantity, result.unit, len(result.seen)) == ("support_N", "N", 1)
    assert (result.max, result.min) == (
        pytest.approx(176.98, abs=0.01),
        pytest.approx(30.13, abs=0.01),
    )
    assert result.variance == pytest.approx(924.6, abs=0.1)
    assert result.range == pytest.approx(result.max - result.min)


def test_signal_adds_force_of_torque_at_lever() -> None:
    rigid, signal = measure_knife(quantity="F_Ox_N", drive="M_c", lever_mm=-25.0)
    torque = simulate_machine(build_knife()).columns["M_c_Nm"]
    assert signal == pytest.approx(rigid - torque / 0.025, rel=1e-12, abs=1e-9)


def test_enclosed_force_counts_once_unless_a_share_is_stated() -> None:
    columns = simulate_machine(build_knife()).columns
    _, full = measure_knife(quantity="F_Ox", enclosed=["F_By"])
    _, half = measure_knife(quantity="F_Ox", enclosed=["F_By_N", "F_Oy_N"], shares=[0.5, -2.0])
    assert full == pytest.approx(columns["F_Ox_N"] + columns["F_By_N"], abs=1e-9)
    assert half == pytest.approx(
        columns["F_Ox_N"] + 0.5 * columns["F_By_N"] - 2 * columns["F_Oy_N"], abs=1e-9
    )


def test_carried_force_obeys_dalembert() -> None:
    """Guide and spring hold the bar: its rate of momentum less its weight and the force of the
    rod.
    """
    machine = build_knife()
    columns, mass, fall = (
        simulate_machine(machine).columns,
        machine.document.si("m_k_kg"),
        machine.document.si("g_m_s2"),
    )
    force_x = mass * columns["a_bar_x_m_s2"] - columns["F_Bx_N"]
    force_y = mass * fall - columns["F_By_N"]
    assert measure_knife(bodies=["bar"], axis="x")[1] == pytest.approx(force_x, abs=1e-9)
    assert measure_knife(bodies=["bar"], axis="y")[1] == pytest.approx(force_y, abs=1e-9)
    _, both = measure_knife(bodies=["crank", "bar"], axis="y")
    assert both == pytest.approx(force_y + columns["F_Oy_N"], abs=1e-9)
    _, turned = measure_knife(bodies=["crank", "bar"], axis_deg=30.0)
    across = (force_x + columns["F_Ox_N"]) * np.cos(np.pi / 6)
    assert turned == pytest.approx(across + both / 2, abs=1e-9)
    assert np.abs(turned - both).max() > 1


def test_carried_force_of_a_device_is_the_support_force() -> None:
    support = simulate_wang(speed_harmonics=[0.1, 0.0, 0.0, 0.0]).measured
    carried = simulate_wang(
        bodies=["sun", "carrier"], axis="y", speed_harmonics=[0.1, 0.0, 0.0, 0.0]
    ).measured
    sun = simulate_wang(bodies=["sun"], axis="y").measured
    assert support is not None
    assert carried is not None
    assert sun is not None
    assert carried.rigid == pytest.approx(support.rigid, abs=1e-9)
    assert carried.signal == pytest.approx(support.signal, abs=1e-9)
    assert np.abs(sun.rigid - support.rigid).max() > 1


@pytest.mark.parametrize(
    "neutral",
    [
        {"enclosed": ["F_Oy_N", "F_By_N"], "shares": [0.0, 0.0]},
        {"imbalance_kg_m": [0.0, 0.0]},
        {"drive": "M_c", "lever_mm": 1e14},
        {"mount_Hz": 1e12, "mount_damping": 0.3},
    ],
    ids=str,
)
def test_effects_of_size_zero_change_nothing(neutral: Mapping[str, Any]) -> None:
    rigid, signal = measure_knife(quantity="F_Ox_N", **neutral)
    assert signal == pytest.approx(rigid, abs=1e-9 * np.ptp(rigid))


@pytest.mark.parametrize("speed", [5.0, -5.0])
def test_mount_equals_integrated_motion(speed: float) -> None:
    """A mass on spring and damper, with the machine's force on it, integrated until it repeats.

    A clockwise drive passes its angles backwards, so that the response is late at smaller angles.
    """
    frequency, damping, phi = 2.3, 0.2, np.linspace(0, TURN, 720, endpoint=False)

    def force(angle: Array | float) -> Array:
        return np.asarray(3 + 2 * np.cos(angle) + np.sin(3 * angle))

    wn, effect = TURN * frequency, ElasticMount(5.0)
    end = 12 * TURN / 5.0
    times = np.linspace(end, end + TURN / 5.0, 721)
    motion = solve_ivp(
        lambda t, y: [y[1], float(force(speed * t)) - 2 * damping * wn * y[1] - wn**2 * y[0]],
        (0, times[-1]),
        [0.0, 0.0],
        t_eval=times,
        rtol=1e-10,
        atol=1e-12,
    )
    reaction = 2 * damping * wn * motion.y[1] + wn**2 * motion.y[0]
    curves = Curves({"": force(phi)[:, None]}, TURN, speed)

    def filter_force(share: float) -> Array:
        ends = zip(effect.parameters, (frequency, share), strict=True)
        values = [parameter.from_display(value) for parameter, value in ends]
        return effect.apply(curves.rows[""], curves, values)[:, 0]

    expected = (reaction if speed > 0 else reaction[::-1])[:-1]
    assert filter_force(damping) == pytest.approx(expected, abs=1e-6)
    assert abs(filter_force(damping / 10) - expected).max() > 0.1


def test_imbalance_turns_with_the_clockwise_drive() -> None:
    rigid, signal = measure_knife(quantity="F_Ox_N", imbalance_kg_m=[0.003, -0.001])
    machine = build_knife()
    phi, square = machine.list_angles(), float(machine.data[machine.speed]) ** 2
    assert signal - rigid == pytest.approx(
        square * (0.003 * np.cos(phi) - 0.001 * np.sin(phi)), abs=1e-9
    )


def check_slopes(curve: SensorCurve) -> None:
    """Compare the slopes of a curve in its inputs with central differences."""
    width = curve.chosen.upper - curve.chosen.lower
    z = curve.chosen.lower + 0.4 * width
    slopes = curve(z)[1] * width
    for i, row in enumerate(1e-5 * np.diag(width)):
        difference = (curve(z + row)[0] - curve(z - row)[0]) / 2e-5
        size = 1 + abs(difference).max()
        assert slopes[:, i] == pytest.approx(difference, abs=1e-4 * size), curve.chosen.names[i]


STATED_EFFECTS: dict[str, tuple[dict[str, Any], dict[str, tuple[float, float]]]] = {
    "quantity": (
        {
            "quantity": "F_Ox_N",
            "drive": "M_in",
            "lever_mm": 80.0,
            "imbalance_kg_m": [0.01, 0.02],
            "speed_harmonics": [0.05, 0.0, 0.0, -0.02],
            "mount_Hz": 40.0,
            "mount_damping": 0.1,
            "corner_Hz": 0.5,
        },
        {
            "lever_mm": (60.0, 100.0),
            "imbalance_kg_m[1]": (0.0, 0.03),
            "speed_harmonics[3]": (-0.05, 0.05),
            "mount_Hz": (35.0, 60.0),
            "mount_damping": (0.05, 0.3),
            "corner_Hz": (0.2, 0.9),
        },
    ),
    "bodies": (
        {"bodies": ["crank", "slider"], "axis_deg": 20.0, "enclosed": ["F_Ay_N"], "shares": [0.5]},
        {"axis_deg": (-40.0, 70.0), "shares[0]": (0.0, 1.0)},
    ),
}


@pytest.mark.parametrize(("stated", "fitted"), STATED_EFFECTS.values(), ids=STATED_EFFECTS.keys())
def test_slopes_of_stated_effects_equal_differences(
    stated: dict[str, Any], fitted: dict[str, tuple[float, float]]
) -> None:
    """Those in the speed, too, on which mounts, couplings and imbalances depend besides their
    curves.
    """
    file = own.file("slider_crank", "", mu=0)
    machine = build_machine(
        build_from_table(file.table() | {"measurement": stated}, "crank.toml", file.place)
    )
    bounds = {
        "m_s_kg": (1.0, 3.0),
        "omega_rpm": (250.0, 400.0),
        "phase_deg": (0.0, 360.0),
        "offset_N": (-9.0, 9.0),
    }
    chosen = Chosen.from_bounds(
        machine, bounds | {f"measurement.{key}": ends for key, ends in fitted.items()}
    )
    degrees = np.arange(0, 360, 9.0)
    empty = Channel("F", "N", np.zeros(40), np.ones(40, dtype=bool), 1.0)
    view = find_sensor_view(machine)
    assert view is not None
    curve = SensorCurve(
        machine, chosen, Measurement(np.radians(degrees), (empty,)), view.quantity.key
    )
    assert len(curve.stated) == len(view.effects) > 1
    check_slopes(curve)


def test_file_without_measurement_reports_none() -> None:
    table, cycle = simulate_wang().result.table(), simulate_machine(build_knife())
    assert "measurement" not in table
    assert "measurement" not in cycle.result.table()
    assert not [key for key in simulate_wang().table() if key.startswith("measured")]
    assert measure_cycle(build_knife(), cycle.machine.list_angles(), cycle.columns) is None


STATED: dict[str, Any] = {
    "quantity": "F_Ox_N",
    "enclosed": ["F_By_N"],
    "shares": [0.3],
    "drive": "M_c_Nm",
    "lever_mm": 90.0,
    "mount_Hz": 35.0,
    "mount_damping": 0.08,
}


def test_simulated_signal_gives_back_mass_and_lever(tmp_path: Path) -> None:
    """Written by `simulate`, read by `calibrate`: the same file but for mass and lever, which are
    found again.
    """
    heavy = write_file(tmp_path, build_knife(**STATED).document.with_numbers({"m_k_kg": 1.43}))
    out = tmp_path / "out"
    result = answer("simulate", heavy, "--out", str(out))
    _, columns = read_cycle_csv(out / "values.csv")
    signal = columns["measured_F_Ox_N"]
    assert result["measurement"]["max"] == pytest.approx(signal.max())
    assert (out / "figures" / "measurement.svg").stat().st_size > 5000
    assert "F_By_N" in (out / "report.html").read_text(encoding="utf-8")
    own_file = write_file(tmp_path, build_knife(**STATED | {"lever_mm": 120.0}).document)
    data = write_data(tmp_path, columns["theta_deg"], signal)
    call = ("--data", data, "--column", "F", "--angle", "angle", "--fit", "m_k_kg=0.8:1.8")
    lever, fit = ("--fit", "measurement.lever_mm=60:200"), tmp_path / "fit"
    result = answer("calibrate", own_file, *call, *lever, "--out", str(fit))
    assert result["quantity"] == "F_Ox_N", "that of the file"
    mass, fitted_lever = result["fitted"]
    assert mass["value"] == pytest.approx(1.43, rel=1e-6)
    assert (fitted_lever["value"], fitted_lever["unit"]) == (pytest.approx(90.0, rel=1e-6), "mm")
    assert fitted_lever["start"] == pytest.approx(120.0)
    assert len([line for line in result["treatment"] if "[measurement]" in line]) == 3
    written = load(fit / "calibrated.toml")
    assert written.origin("measurement.lever_mm").startswith("calibrated")
    assert written.measurement is not None
    assert written.measurement.lever_mm == pytest.approx(90.0, rel=1e-6)
    crossing = refusal("calibrate", own_file, *call, "--fit", "measurement.lever_mm=-60:200")
    assert "measurement.lever_mm=-60:200: it must not be 0" in crossing
    assert "measurement.mount_Hz" in refusal(
        "calibrate", own_file, *call, "--fit", "measurement.mount_Hz=-1:20"
    )
    other = refusal("calibrate", own_file, *call, *lever, "--quantity", "F_Oy_N")
    assert "measures F_Ox_N, not F_Oy_N" in other
    assert "measurement.shares[0]" in refusal(
        "calibrate", own_file, *call, "--fit", "measurement.share=0:1"
    )
    rigid = write_file(tmp_path, build_knife().document)
    missed = answer("calibrate", rigid, *call, "--quantity", "F_Ox_N")
    assert missed["reached"]["rms"] > 1


def test_second_quantity_stays_rigid(tmp_path: Path) -> None:
    """The file speaks of one sensor; another column is another sensor."""
    cycle = simulate_machine(build_knife(**STATED).with_numbers({"m_k_kg": 1.43}))
    assert cycle.measured is not None
    path = tmp_path / "data.csv"
    rows = zip(cycle.angles_deg, cycle.measured.signal, cycle.columns["M_c_Nm"], strict=True)
    path.write_text(
        "a [deg],F [N],M [Nm]\n" + "".join(f"{a},{f},{m}\n" for a, f, m in rows), encoding="utf-8"
    )
    file = write_file(tmp_path, build_knife(**STATED).document)
    result = answer(
        *(
            f"calibrate {file} --data {path} --angle a --column F --quantity F_Ox --column M "
            "--quantity M_c --fit m_k_kg=0.8:1.8"
        ).split()
    )
    assert result["fitted"][0]["value"] == pytest.approx(1.43, rel=1e-6)
    assert max(channel["rms"] for channel in result["models"]["derived"]["channels"]) < 1e-6


@pytest.mark.usefixtures("blank_figures")
def test_explained_lever_is_written_to_the_calibrated_file(tmp_path: Path) -> None:
    """Data behind a lever, explained without [measurement]: the written file simulates the data."""
    measured = simulate_machine(
        build_knife(quantity="F_Ox_N", drive="M_c", lever_mm=90.0), 120
    ).measured
    assert measured is not None
    data = write_data(
        tmp_path, measured.angles_deg, np.roll(measured.signal, -round(PHASE_DEG / 3)) + 3.0
    )
    out = tmp_path / "out"
    call = ("--data", data, "--column", "F", "--angle", "angle", "--quantity", "F_Ox", "--explain")
    result = answer(
        "calibrate", write_file(tmp_path, build_knife().document), *call, "--out", str(out)
    )
    assert result["preferred"] == "lever M_c_Nm"
    calibrated = str(out / "calibrated.toml")
    assert "[measurement]" in Path(calibrated).read_text(encoding="utf-8")
    written = answer(*f"simulate {calibrated} --samples 120 --out {tmp_path / 'again'}".split())
    _, columns = read_cycle_csv(tmp_path / "again" / "values.csv")
    signal = columns["measured_F_Ox_N"]
    assert signal == pytest.approx(measured.signal, abs=0.05)
    assert written["measurement"]["variance"] == pytest.approx(measured.signal.var(), rel=1e-3)
    again = answer("calibrate", calibrated, *call)
    assert again["preferred"] == "stated", "the file explains the data"
    assert not [row for row in again["explanations"] if "lever" in row["name"]], "not offered twice"


@pytest.mark.long
def test_second_effect_is_explained_upon_the_stated_one(tmp_path: Path) -> None:
    stated = {"quantity": "F_Ox_N", "drive": "M_c", "lever_mm": 90.0}
    measured = simulate_machine(
        build_knife(**stated, enclosed=["F_By_N"], shares=[0.3]), 120
    ).measured
    assert measured is not None
    noise = np.random.default_rng(3).normal(0, 0.3, 120)
    data = write_data(tmp_path, measured.angles_deg, measured.signal + noise)
    file, out = write_file(tmp_path, build_knife(**stated).document), tmp_path / "out"
    answer(
        *f"calibrate {file} --data {data} --column F --angle angle --explain --out {out}".split()
    )
    written = answer("simulate", str(out / "calibrated.toml"), "--samples", "120")["measurement"]
    assert len(written["seen"]) == 2
    assert written["variance"] == pytest.approx(measured.signal.var(), rel=0.01)


REFUSED: dict[str, tuple[dict[str, Any], str]] = {
    "unknown quantity": ({"quantity": "F_Oxx_N"}, "F_Ox_N"),
    "no quantity": ({"corner_Hz": 1.0}, "quantity"),
    "unknown enclosed": ({"quantity": "F_Ox_N", "enclosed": ["F_Byy"]}, "F_By"),
    "enclosed of another unit": ({"quantity": "F_Ox_N", "enclosed": ["M_c"]}, "F_By_N"),
    "enclosed twice": ({"quantity": "F_Ox_N", "enclosed": ["F_By", "F_By_N"]}, "once"),
    "shares without enclosed": ({"quantity": "F_Ox_N", "shares": [1.0]}, "enclosed"),
    "shares of another length": (
        {"quantity": "F_Ox_N", "enclosed": ["F_By_N"], "shares": [1.0, 1.0]},
        "1",
    ),
    "unknown body": ({"bodies": ["bat"], "axis": "x"}, "bar"),
    "body that the ground does not touch": ({"bodies": ["rod"], "axis": "x"}, "crank, bar"),
    "body twice": ({"bodies": ["bar", "bar"], "axis": "x"}, "once"),
    "bodies beside a quantity": (
        {"quantity": "F_Ox_N", "bodies": ["bar"], "axis": "x"},
        "left out",
    ),
    "bodies without axis": ({"bodies": ["bar"]}, "axis_deg"),
    "axis without bodies": ({"quantity": "F_Ox_N", "axis": "x"}, "bodies"),
    "axis out of the plane": ({"bodies": ["bar"], "axis": "z"}, "along x, y alone"),
    "swing along a turned axis": (
        {"bodies": ["bar"], "axis_deg": 3.0, "speed_harmonics": [0.1, 0, 0, 0]},
        "use axis",
    ),
    "nothing measured": ({"lever_mm": 9.0, "drive": "M_c"}, "bodies with axis"),
    "unknown drive": ({"quantity": "F_Ox_N", "drive": "M_cc", "lever_mm": 9.0}, "M_c"),
    "drive that is a force": ({"quantity": "F_Ox_N", "drive": "F_By_N", "lever_mm": 9.0}, "M_c_Nm"),
    "drive without lever": ({"quantity": "F_Ox_N", "drive": "M_c"}, "lever_mm"),
    "lever of zero": ({"quantity": "F_Ox_N", "drive": "M_c", "lever_mm": 0.0}, "lever_mm"),
    "lever of a length": ({"quantity": "s_mm", "drive": "M_c", "lever_mm": 9.0}, "force in N"),
    "imbalance of a length": ({"quantity": "s_mm", "imbalance_kg_m": [0.1, 0.0]}, "force in N"),
    "harmonics that reverse": (
        {"quantity": "F_Ox_N", "speed_harmonics": [0.8, 0.0, 0.0, 0.3]},
        "less than 1",
    ),
    "harmonics without acceleration": (
        {"quantity": "F_Ox_N", "speed_harmonics": [0.1, 0.0, 0, 0]},
        "acceleration=",
    ),
    "mount without damping": ({"quantity": "F_Ox_N", "mount_Hz": 9.0}, "mount_damping"),
}


@pytest.mark.parametrize(("stated", "hint"), REFUSED.values(), ids=REFUSED.keys())
def test_wrong_measurement_is_refused(stated: dict[str, Any], hint: str) -> None:
    with pytest.raises(InputError) as error:
        build_knife(**stated)
    message = str(error.value)
    assert "knife.toml: measurement." in message
    assert hint in message.partition("measurement.")[2]
    wrong = {key: value for key, value in stated.items() if key != "quantity"} or stated
    assert any(f"measurement.{key}" in message for key in wrong) or "missing" in message


def test_commands_refuse_a_wrong_measurement(tmp_path: Path) -> None:
    path = tmp_path / "wrong.toml"
    table = machines.machine(WANG).table() | {"measurement": {"drive": "M_LL", "lever_mm": 37.2}}
    path.write_text("\n".join(format_lines(table, {})), encoding="utf-8")
    for command in ("simulate", "validate"):
        message = refusal(command, str(path))
        assert "measurement.drive" in message
        assert "M_LL" in message
        assert "did you mean M_L" in message


def test_free_motion_has_no_measurement() -> None:
    file = own.file("spinning_top")
    with pytest.raises(InputError, match="no angle drives"):
        build_from_table(
            file.table() | {"measurement": {"quantity": "F_Ox_N"}}, "top.toml", file.place
        )


@pytest.mark.parametrize(
    "build", [build_wang, lambda **stated: build_knife(**stated).document], ids=["device", "own"]
)
def test_studio_moves_the_sensor(tmp_path: Path, build: Callable[..., Document]) -> None:
    """A lever of twice the length is half the torque's force; a page without a server has the rigid
    machine.
    """
    is_device = build is build_wang
    lever = {"drive": "M_L" if is_device else "M_c", "lever_mm": 60.0}
    stated = lever if is_device else {"bodies": ["crank"], "axis": "x"} | lever
    view = open_machine(write_file(tmp_path, build(**stated)))
    assert isinstance(view, Movable)
    values = {control.path: control.value for control in view.controls}
    assert values["measurement.lever_mm"] == 60.0
    signals = []
    for length in (60.0, 80.0, 1e9):
        moved = values | {"measurement.lever_mm": length}
        signals.append(view.scenes(moved, "exact")[0].curves[0].values)
        highest, lowest = (reading.value for reading in view.readings(moved, "exact")[:2])
        assert highest is not None
        assert lowest is not None
        assert highest >= signals[-1].max() - 0.01 * np.ptp(signals[-1])
        assert lowest <= signals[-1].min() + 0.01 * np.ptp(signals[-1])
        assert f"lever_mm = {length!r}" in view.text(moved)
    assert 4 * (signals[1] - signals[2]) == pytest.approx(3 * (signals[0] - signals[2]), abs=1e-4)
    assert np.ptp(signals[0] - signals[2]) > 1
    assert {control.path for control in view.rigid.controls} == values.keys() - {
        "measurement.lever_mm"
    }
    assert StaticPageModel(view.rigid, "exact").json()
    assert "lever_mm = 60.0" in file_template(view, view.rigid.controls)["lines"]


def test_gain_magnifies_signal() -> None:
    machine, phi = build_knife(quantity="F_Oy_N", gain=1.3), np.linspace(0, 6, 50)
    signal = measure_cycle(machine, phi, {})
    assert signal is not None
    assert signal.signal == pytest.approx(1.3 * signal.rigid, rel=1e-6)
    with pytest.raises(InputError, match="gain"):
        build_knife(quantity="F_Oy_N", gain=-1.0)
