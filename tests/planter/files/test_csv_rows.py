"""The reader of CSV files: header, comments, lines in complaints, and what a person would do
next.
"""

from __future__ import annotations

import re

import pytest

from planter.errors import InputError
from planter.files import csv_rows
from planter.papers.mapping.curve import load_curve
from planter.papers.pickup.file import parse_points
from tests.support.cli import refusal

GOOD = "# first\n\nx_mm, y_mm\n1,2\n# in between\n3,4.5\n"


def refused(text: str, columns: tuple[str, ...] = ("x_mm", "y_mm")) -> str:
    def read() -> None:
        table = csv_rows.read_table(text, "a.csv", columns)
        for name in table.header:
            table.numbers(name)

    with pytest.raises(InputError) as error:
        read()
    return str(error.value)


def test_comments_and_empty_lines_leave_lines_their_numbers() -> None:
    table = csv_rows.read_table(GOOD, "a.csv", ("y_mm", "x_mm"))
    assert table.numbers("y_mm") == [2, 4.5]
    assert table.lines == (4, 6)
    assert table.comments == ((1, "first"), (5, "in between"))


@pytest.mark.parametrize("separator", [";", "\t"])
def test_spreadsheets_with_decimal_commas_are_read(separator: str) -> None:
    """The same numbers as with commas and points, from which columns differ."""
    text = GOOD.replace(",", separator).replace(".", ",")
    tables = [csv_rows.read_table(each, "a.csv", ("y_mm", "x_mm")) for each in (GOOD, text)]
    assert tables[0].rows == tables[1].rows
    assert tables[1].numbers("y_mm") == [2, 4.5]


BAD = {
    "none": ("", (), "the file is empty, it must have a header and rows"),
    "none of some": ("", ("x",), "the file is empty, it must have the header x and rows"),
    "header": ("x,y\n1,2\n", ("x_mm", "y_mm"), "line 1: the header 'x,y': it must be x_mm,y_mm"),
    "no header": ("1,2\n3,4\n", ("x_mm", "y_mm"), "the names of the columns must stand above"),
    "no header, any": ("1,2\n3,4\n", (), "the header holds numbers"),
    "semicolons in rows alone": ("x,y\n1;2\n", (), "line 2 has 1 cells, but it must have 2"),
    "thousands": ("x;y\n1.000,5;2\n", (), r"line 2, column x: '1.000,5'"),
    "decimal commas": (
        "x,y\n1,2\n1,5,2,5\n",
        (),
        "line 3 has 4 cells, but it must have 2 .* write 1.5, not 1,5",
    ),
    "a decimal comma": (
        'x,y\n"1,5",2\n',
        (),
        r"line 2, column x: '1,5'.* \(with a decimal point: 1.5\)",
    ),
    "long": (f"x,y\n{'7' * 1001},2\n", (), "line 2 has a cell of more than 1000 characters"),
    "longer than the library reads": (
        f"x,y\n{'7' * 131073},2\n",
        (),
        "line 2 has a cell of more than 1000",
    ),
    "TOML": ('[path]\ncsv = "a"\n', (), "as in a file of another kind, but it must be a CSV file"),
    "TOML, a key": ("a = 1\n", ("x",), "it must be a CSV file: the header x, then rows"),
}


@pytest.mark.parametrize("kind", BAD)
def test_complaints_name_line_and_remedy(kind: str) -> None:
    text, columns, message = BAD[kind]
    assert re.search(message, refused(text, columns)), refused(text, columns)


def test_long_texts_are_cut_in_complaints() -> None:
    assert len(refused(f"x,y\n{'a' * 900},2\n", ())) < 250
    assert len(refused(f"{'a' * 900},y\n1,2\n")) < 250


@pytest.mark.parametrize("header", ["x_mm,y_mm", "carrier_deg,relative_deg", "A,Y"])
def test_huge_cell_is_refused_by_every_command(header: str, tmp_path) -> None:  # type: ignore[no-untyped-def]
    path = tmp_path / "huge.csv"
    path.write_text(f"{header}\n1,{'1' * 200_000}\n2,3\n")
    command = {
        "x_mm,y_mm": ["pickup"],
        "carrier_deg,relative_deg": ["train"],
        "A,Y": ["clutch", "field"],
    }[header]
    assert "line 2 has a cell of more than 1000 characters" in refusal(*command, str(path))


def test_paths_and_curves_are_read_by_the_names_of_their_columns(tmp_path) -> None:  # type: ignore[no-untyped-def]
    ring = [(k, 0) for k in range(5)] + [(4, 1)] + [(k, 2) for k in range(4, -1, -1)] + [(0, 1)]
    turned = "y_mm,x_mm\n" + "".join(f"{y},{x}.25\n" for x, y in ring)
    points, resolution = parse_points(turned, "a.csv")
    assert points[8].tolist() == pytest.approx([0.00225, 0.002])
    assert resolution == pytest.approx(1e-5)
    path = tmp_path / "curve.csv"
    path.write_text("relative_deg,carrier_deg\n0,0\n-90,120\n-200,240\n-360,360\n")
    assert load_curve(path).relative[1] == pytest.approx(-1.5707963267948966)
