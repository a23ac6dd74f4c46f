"""A machine as C that stands alone: it compiles without a warning and finds what `planter`
finds.
"""

import subprocess
from pathlib import Path

import numpy as np
import pytest

from planter import simulate
from planter.exports import c99
from planter.exports.quantities import build_name, list_quantities, to_identifier
from planter.files import examples, units
from planter.papers.planting.file import load
from planter.papers.planting.functions import MODELS, Model
from planter.papers.planting.model import Device, build_machine
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


def test_exchanged_sides_are_detected(tmp_path: Path) -> None:
    device = Device(load("wang2017"))
    files = written(device, tmp_path)
    second = "q + WANG2017_SIDE * angles"
    files[1].write_text(files[1].read_text().replace(f"q, {second}", f"{second}, q"))
    assert furthest(device, run_program(built(files, "gcc", "-O0"), "turn")) > 1e-3


def test_names_are_identifiers() -> None:
    assert [to_identifier(n) for n in ("wang2017", "A-b c", "2nd", "Größe", "*/")] == [
        "wang2017",
        "a_b_c",
        "m_2nd",
        "gr_e",
        "m_",
    ]


def test_built_in_machines_have_unique_names() -> None:
    names = [
        build_name(build_machine(Device(load(n), m)))
        for n in examples.list_examples("planting", ".toml")
        for m in MODELS
    ]
    assert len(set(names)) == len(names)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--turns", "0"), "between 1 and 555 with 360 samples"),
        (("--turns", "99999"), "--turns = 99999"),
        (("--samples", "4"), "between 8 and"),
    ],
)
def test_invalid_motion_is_refused(
    arguments: tuple[str, ...], message: str, tmp_path: Path
) -> None:
    assert message in refusal("export", "motion", "wang2017", *arguments, "--out", str(tmp_path))
