"""A machine as C that stands alone: it compiles without a warning and finds what `planter`
finds.
"""

import subprocess
from pathlib import Path

import numpy as np
import pytest

from planter import simulate
from planter.engine.goal import Goal
from planter.exports import c99
from planter.exports.quantities import build_name, list_quantities, to_identifier
from planter.files import examples, units
from planter.planting.file import load
from planter.planting.functions import MODELS, Model
from planter.planting.model import Device, build_machine
from tests.support import swapped
from tests.support.cli import answer, refusal
from tests.support.lanes import STRICT, path_of

OBJECTIVE = ("range_N", "variance_N2", "mean_N")


def built(files: list[Path], compiler: str, *flags: str) -> Path:
    """The exported program, its parts compiled each with every warning an error."""
    sources, target = [f for f in files if f.suffix == ".c"], files[0].with_suffix(f".{compiler}")
    objects = [source.with_suffix(".o") for source in sources]
    for source, compiled in zip(sources, objects, strict=True):
        command = [path_of(compiler), *STRICT, *flags, "-c", str(source), "-o", str(compiled)]
        subprocess.run(command, check=True, capture_output=True, text=True)
    subprocess.run([path_of(compiler), *map(str, objects), "-lm", "-o", str(target)], check=True)
    return target


def run_program(command: Path, *arguments: str) -> list[str]:
    return subprocess.run(
        [command, *arguments], check=True, capture_output=True, text=True
    ).stdout.splitlines()


def numbers(program: Path) -> dict[str, float]:
    """What an exported program prints by itself."""
    return {name: float(value) for name, value in map(str.split, run_program(program))}


def furthest(device: Device, lines: list[str]) -> float:
    """How far a printed turn is from the device's, of each quantity's largest number."""
    rows = np.array([[float(cell) for cell in line.split(",")] for line in lines[1:]])
    columns = device.columns(device.design, rows[:, 0])
    del columns["phi_deg"]
    names = [quantity.name for quantity in list_quantities(device.engine)]
    assert lines[0].split(",") == ["phi", *names]
    expected = np.array([column * units.unit_factor(key) for key, column in columns.items()])
    return float(
        (np.abs(rows[:, 1:].T - expected).max(axis=1) / np.abs(expected).max(axis=1)).max()
    )


NATIVE = ("-O3", "-march=native", "-ffast-math")


@pytest.mark.parametrize(
    ("name", "model", "compiler", "flags"),
    [
        ("wang2017", "exact", "gcc", ("-O1",)),
        ("compact", "printed", "gcc", ("-O1",)),
        pytest.param("compact", "printed", "gcc", NATIVE, marks=pytest.mark.long),
        ("compact", "exact", "clang", ("-O1",)),
    ],
)
def test_program_equals_simulate(
    name: str, model: Model, compiler: str, flags: tuple[str, ...], tmp_path: Path
) -> None:
    # off the file's own angle, at which the cam's flanks begin at samples: gradients have a side
    # there
    alpha3_deg = load(name).numbers()["design.alpha3_deg"] + 0.013
    options = ("--model", model, "--set", f"alpha3_deg={alpha3_deg!r}")
    files = [
        Path(p) for p in answer("export", "c", name, *options, "--out", str(tmp_path))["files"]
    ]
    program = built(files, compiler, *flags)
    values = numbers(program)
    expected = answer("simulate", name, *options)
    assert values["objective"] == pytest.approx(expected["objective"], rel=1e-12)
    device = Device(load(name, {"alpha3_deg": alpha3_deg}), model)
    sampled = expected["support_force"] | {"mean_N": simulate(device).columns["support_N"].mean()}
    for key in OBJECTIVE:
        assert values[key] == pytest.approx(sampled[key], rel=1e-11)
    samples = str(device.machine.objective.samples)
    gradient = answer("sensitivity", name, *options, "--samples", samples)["gradient"]
    slopes = {
        n: values[f"gradient.{n}"] * s for n, s in zip(device.names, device.scale, strict=True)
    }
    width = dict(zip(device.names, (device.upper - device.lower) / device.scale, strict=True))
    largest = max(abs(gradient[n] * width[n]) for n in gradient)
    assert all(abs(slopes[n] - gradient[n]) * width[n] <= 1e-10 * largest for n in gradient)
    lines = run_program(program, "turn")
    assert len(lines) == 1 + device.machine.objective.samples
    assert furthest(device, lines) <= 1e-12


def written(device: Device, folder: Path) -> list[Path]:
    texts = c99.build_source_files(build_machine(device))
    for file, text in texts.items():
        (folder / file).write_text(text)
    return [folder / file for file in texts]


def test_another_machine_an_odd_number_of_samples(tmp_path: Path) -> None:
    table = swapped.table()
    table["objective"]["samples"], table["name"] = 37, "My 2nd */ machine"
    device = Device(swapped.PlantingMachine.read(table, "swapped.toml"))
    files = written(device, tmp_path)
    assert [f.name for f in files] == [
        "my_2nd_machine.h",
        "my_2nd_machine.c",
        "my_2nd_machine_main.c",
    ]
    goal = Goal(device.engine, device.engine.objective, (), 37)
    value, gradient = goal.evaluate(device.design), goal.slope(device.design)
    values = numbers(built(files, "gcc", "-O1"))
    assert values["objective"] == pytest.approx(value, rel=1e-12)
    slopes = np.array([values[f"gradient.{name}"] for name in device.names])
    width = device.upper - device.lower
    assert np.abs((slopes - gradient) * width).max() <= 1e-10 * np.abs(gradient * width).max()


def test_another_design_is_another_number(tmp_path: Path) -> None:
    """The program's number is computed: with a number of the machine changed in its text it is
    another one.
    """
    files = written(Device(load("wang2017")), tmp_path)
    before = numbers(built(files, "gcc", "-O0"))["objective"]
    text = files[1].read_text()
    head, mark, data = text.partition("const double wang2017_machine[WANG2017_MACHINE] = {")
    first, comma, rest = data.partition(", ")
    files[1].write_text(head + mark + repr(1.1 * float(first)) + comma + rest)
    assert numbers(built(files, "gcc", "-O0"))["objective"] != pytest.approx(before, rel=1e-3)


def test_exchanged_sides_are_detected(tmp_path: Path) -> None:
    device = Device(load("wang2017"))
    files = written(device, tmp_path)
    second = "q + WANG2017_SIDE * angles"
    files[1].write_text(files[1].read_text().replace(f"q, {second}", f"{second}, q"))
    assert furthest(device, run_program(built(files, "gcc", "-O0"), "turn")) > 1e-3


@pytest.mark.parametrize("model", MODELS)
def test_units_meanings_and_equations_stand_in_the_header(model: Model) -> None:
    device = Device(load("wang2017"), model)
    header = " ".join(
        next(iter(c99.build_source_files(build_machine(device)).values()))
        .replace("\n *", " ")
        .split()
    )
    assert "x[4] R3_mm: R [m] radius of the eccentric circle (wang2017 3.4)" in header
    assert "x[9] m61: m61 [1] deformation coefficient of gear 6 (wang2017 3.4)" in header
    for entry in device.sidecar["vectors"]["machine"]:
        assert f"{entry['name']} [{entry['unit']}] {entry['meaning']}" in header
    for number, q in enumerate(list_quantities(device.engine)):
        assert f"q[{number}] {q.name} [{q.unit}] {q.meaning}" in header
    for equation in device.sidecar["equations"]:
        assert equation in header
    assert ("wang2017 (18)" in header) == (model == "printed")


def test_names_are_identifiers() -> None:
    assert [to_identifier(n) for n in ("wang2017", "A-b c", "2nd", "Größe", "*/")] == [
        "wang2017",
        "a_b_c",
        "m_2nd",
        "gr_e",
        "m_",
    ]


def test_unwritable_folder_is_refused() -> None:
    assert "/dev/null/x" in refusal("export", "c", "wang2017", "--out", "/dev/null/x")


def test_built_in_machines_have_unique_names() -> None:
    names = [
        build_name(build_machine(Device(load(n), m)))
        for n in examples.list_examples("planting", ".toml")
        for m in MODELS
    ]
    assert len(set(names)) == len(names)
