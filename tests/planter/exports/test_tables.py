"""Tables over time: what is written reads back as the numbers that went in, in the units that the
dictionary says.
"""

import csv
import io
import re

import numpy as np
import pytest
from scipy.io import loadmat

from planter.exports.motion_tables import (
    DICTIONARY,
    FORMATS,
    Column,
    MotionTable,
    convert_to_millimetres,
)
from planter.kernels import Array
from planter.report.options import MotionFormat

TIME = np.linspace(0.0, 0.7, 9)
NUMBERS = {
    "time": ("time_s", "s", TIME),
    "x": ("x_mm", "m", 0.1 * np.cos(TIME) / 3),
    "turn": ("turn_deg", "rad", -(TIME**3)),
    "M": ("M_Nm", "N m", 1e-7 * np.exp(TIME)),
    "loss": ("loss_W", "W", 7e5 * TIME),
    "omega": ("omega_rad_s", "rad/s", -1 / (1 + TIME)),
    "omega_dot": ("omega_dot_rad_s2", "rad/s2", TIME - 0.3),
}


def motion() -> MotionTable:
    columns = (
        Column(n, key, unit, f'what "{n}", means', "made up", v)
        for n, (key, unit, v) in NUMBERS.items()
    )
    return MotionTable("toy", ("a toy", "a note that is long " * 20), tuple(columns))


def rows(content: bytes) -> list[dict[str, str]]:
    """The rows of a CSV file below its comments."""
    lines = [line for line in content.decode().splitlines() if not line.startswith("#")]
    return list(csv.DictReader(lines))


def from_csv(files: dict[str, bytes], place: str) -> Array:
    return np.array([float(row[place]) for row in rows(files["motion.csv"])])


def from_solidworks(files: dict[str, bytes], place: str) -> Array:
    points = np.loadtxt(io.BytesIO(files[place]), delimiter=",")
    assert points[:, 0].tolist() == TIME.tolist()
    column: Array = points[:, 1]
    return column


def from_simulink(files: dict[str, bytes], place: str) -> Array:
    content = loadmat(io.BytesIO(files["motion.mat"]))
    assert [name for name in content if not name.startswith("_")] == ["motion"]
    column: Array = content["motion"][int(place) - 1]
    return column


SPLINE = re.compile(
    r"data_element create spline\s+spline_name = (\w+)\s+comments = \"[^\"]*\"\s+x = "
    r"([^a-z]*)\s+y = ([^a-z]*)\s+"
    r"linear_extrapolate = no"
)


def from_adams(files: dict[str, bytes], place: str) -> Array:
    """By the commands' own syntax: a line goes on where it ends in &, what follows ! is a
    comment.
    """
    text = re.sub(r"^!.*\n", "", files["motion.cmd"].decode("ascii"), flags=re.MULTILINE)
    splines = {name: (x, y) for name, x, y in SPLINE.findall(re.sub(r"&\n", " ", text))}
    x, y = ([float(number) for number in part.split(",")] for part in splines[place])
    assert x == TIME.tolist()
    return np.array(y)


READERS = {
    "csv": from_csv,
    "solidworks": from_solidworks,
    "simulink": from_simulink,
    "adams": from_adams,
}


def test_every_format_has_a_reader_here() -> None:
    assert set(READERS) == set(FORMATS) == set(MotionFormat)


@pytest.mark.parametrize("form", FORMATS)
def test_written_tables_read_back(form: str) -> None:
    """The dictionary's factors lead back to SI, to rounding; every quantity but the time stands in
    it.
    """
    files = FORMATS[form](motion())
    dictionary = {row["name"]: row for row in rows(files[DICTIONARY])}
    assert set(dictionary) | {"time"} == set(NUMBERS)
    for name, row in dictionary.items():
        place = next(iter(row.values()))
        values = READERS[form](files, place) * float(row["si_per_unit"])
        np.testing.assert_allclose(values, NUMBERS[name][2], rtol=4e-16)
        assert row["meaning"] == f'what "{name}", means'
    moved = (
        READERS[form](files, next(iter(dictionary["x"].values())))
        * 1.001
        * float(dictionary["x"]["si_per_unit"])
    )
    assert np.abs(moved - NUMBERS["x"][2]).max() > 1e-6


@pytest.mark.parametrize("form", FORMATS)
def test_the_same_bytes_each_time(form: str) -> None:
    assert FORMATS[form](motion()) == FORMATS[form](motion())


@pytest.mark.parametrize(
    ("unit", "expected", "factor"),
    [
        ("m", "mm", 1e-3),
        ("N m", "N mm", 1e-3),
        ("rad/s2", "deg/s2", np.pi / 180),
        ("W", "N mm/s", 1e-3),
        ("N", "N", 1),
        ("kg m2", "kg mm2", 1e-6),
        ("N/m", "N/mm", 1e3),
        ("m/s", "mm/s", 1e-3),
        ("1", "1", 1),
    ],
)
def test_units_of_millimetres(unit: str, expected: str, factor: float) -> None:
    converted = convert_to_millimetres(Column("q", "q", unit, "", "", TIME), "q")
    assert (converted.unit, converted.factor) == (expected, pytest.approx(factor, rel=1e-15))
