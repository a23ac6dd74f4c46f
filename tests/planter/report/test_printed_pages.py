"""Printed reports: the main part has three sheets of A4, and nothing on it is too small to read."""

from __future__ import annotations

import csv
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from planter.files import examples
from tests.support import own
from tests.support.browser import FLAGS, browser
from tests.support.cli import run

MOST_SHEETS = 3
"""Sheets of the main part."""
LEAST_PT = 7.0
"""Least size of a label [pt]."""
ROUNDING_PT = 1e-3
"""Rounding of pixels [pt]."""
PRINTED_PX = 680
"""Width of the printed column, 180 mm, in pixels."""
ZOOM = 3
"""Largest scale at which sizes of a PDF are read, as whole numbers."""
UNFOLDED = "<style>.details { display: none; }</style></head>"
"""What leaves the main part of a page."""
SIZES = """() => [...document.querySelectorAll("p, td, th, dt, dd, h1, h2, text, li, figcaption")]
  .filter((part) => part.textContent.trim() && part.checkVisibility()
    && part.getBoundingClientRect().width > 1)
  .map((part) => {
    const matrix = part.closest("svg") ? part.getScreenCTM() : { a: 1, b: 0, c: 0, d: 1 };
    const scale = Math.sqrt(Math.abs(matrix.a * matrix.d - matrix.b * matrix.c));
    return [0.75 * scale * parseFloat(getComputedStyle(part).fontSize), part.textContent.trim()];
  })"""
"""Sizes [pt] of all texts."""
SCALES = """() => [...document.querySelectorAll("figure > svg")]
  .filter((part) => part.checkVisibility())
  .map((part) => 0.75 * part.getBoundingClientRect().width / part.viewBox.baseVal.width)"""
"""Scales of figures, whose view boxes are in points."""


def count_sheets(page: str, folder: Path) -> int:
    """Return the number of sheets on which a browser prints a page."""
    source, printed = folder / "printed.html", folder / "printed.pdf"
    source.write_text(page, encoding="utf-8")
    command = [browser(), *FLAGS, f"--user-data-dir={folder / 'profile'}"]
    command += [f"--print-to-pdf={printed}", "--no-pdf-header-footer", source.as_uri()]
    subprocess.run(command, check=True, capture_output=True, timeout=120)
    return len(re.findall(rb"/Type\s*/Page\b", printed.read_bytes()))


def read_font_sizes(printed: Path) -> set[float]:
    """Return the sizes [pt] of all texts of a PDF, to a third of a point; figures have their letters as
    outlines.
    """
    program = shutil.which("pdftohtml")
    if program is None:
        pytest.skip("needs pdftohtml of poppler")
    command = [program, "-xml", "-i", "-zoom", str(ZOOM), "-stdout", str(printed)]
    text = subprocess.run(command, check=True, capture_output=True, text=True, timeout=60).stdout
    sizes = re.findall(r'<fontspec [^>]*size="(\d+)"', text)
    return {int(size) / ZOOM for size in sizes}


def count_main_sheets(page: str, folder: Path) -> int:
    return count_sheets(page.replace("</head>", UNFOLDED, 1), folder)


@pytest.fixture(scope="module")
def crank(tmp_path_factory: pytest.TempPathFactory) -> str:
    """A slider-crank with a goal, and with one limit that it cannot satisfy."""
    path = own.generated("slider_crank") / "printed_crank.toml"
    text = path.with_name("slider_crank.toml").read_text(encoding="utf-8")
    goal = '[objective]\nleast = "range F_Ox"\n\n[requirements]\nhold = ["abs F_Ax <= 60 N"]\n'
    path.write_text(f"{text}\n{goal}", encoding="utf-8")
    return str(path)


@pytest.fixture(scope="module")
def heavier(tmp_path_factory: pytest.TempPathFactory) -> str:
    """The wide device with a heavier planet."""
    path = tmp_path_factory.mktemp("printed") / "heavier.toml"
    text = examples.example("wang2017-wide")
    assert "planet_kg = 1.20" in text
    path.write_text(text.replace("planet_kg = 1.20", "planet_kg = 1.35"), encoding="utf-8")
    return str(path)


COMMANDS = ("simulate device", "simulate crank", "diff", "gears", "optimise", "calibrate")


@pytest.fixture(scope="module")
def measured(crank: str, tmp_path_factory: pytest.TempPathFactory) -> str:
    """The motor's torque of the slider-crank with a spring that is stiffer than stated."""
    folder = tmp_path_factory.mktemp("measured")
    run("simulate", crank, "--set", "k_N_m=1000", "--out", str(folder / "run"))
    lines = (folder / "run" / "values.csv").read_text(encoding="utf-8").splitlines()
    rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    path = folder / "measured.csv"
    noise = np.random.default_rng(1).normal(0.0, 0.02, len(rows))
    pairs = (
        f"{row['phi_deg']},{float(row['M_in_Nm']) + error:.6f}"
        for row, error in zip(rows[::4], noise, strict=False)
    )
    path.write_text("\n".join(["phi_deg,M_in_Nm", *pairs]) + "\n", encoding="utf-8")
    return str(path)


@pytest.mark.parametrize("command", COMMANDS)
def test_main_part_has_three_sheets(
    command: str, crank: str, heavier: str, measured: str, tmp_path: Path
) -> None:
    words = {
        "simulate device": ("simulate", "wang2017-wide"),
        "simulate crank": ("simulate", crank),
        "diff": ("diff", "wang2017-wide", heavier),
        "gears": ("gears", "wang2017", "--module", "2"),
        "optimise": ("optimise", crank, "--starts", "2"),
        "calibrate": (
            "calibrate",
            crank,
            "--data",
            measured,
            "--column",
            "M_in_Nm",
            "--angle",
            "phi_deg",
            "--quantity",
            "M_in_Nm",
            "--fit",
            "k_N_m=500:1500",
        ),
    }[command]
    _, printed, refused = run(*words, "--out", str(tmp_path / "out"))
    assert printed, refused
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    main = count_main_sheets(page, tmp_path)
    assert main <= MOST_SHEETS
    # the rest is printed as well, from a new sheet on, although it is folded on screen
    assert count_sheets(page, tmp_path) > main
    if command == "simulate device":  # tampered: all of it in the main part is too much
        unfolded = page.replace('<div class="details">', "<div>").replace(
            "<details>", "<details open>"
        )
        assert count_main_sheets(unfolded, tmp_path) > MOST_SHEETS
    check_sizes(page, tmp_path)


def check_sizes(page: str, folder: Path) -> None:
    """Assert that all texts of a printed page can be read, and that figures are not shrunk."""
    from playwright.sync_api import sync_playwright

    source = folder / "sizes.html"
    source.write_text(page, encoding="utf-8")
    with (
        sync_playwright() as play,
        play.chromium.launch(executable_path=browser(), args=["--no-sandbox"]) as chromium,
    ):
        sheet = chromium.new_page(viewport={"width": PRINTED_PX, "height": 1000})
        sheet.emulate_media(media="print")
        sheet.goto(source.as_uri())
        sizes, scales = sheet.evaluate(SIZES), sheet.evaluate(SCALES)
        sheet.add_style_tag(content="td { font-size: 6pt !important; }")
        tampered = sheet.evaluate(SIZES)
    assert min(sizes)[0] >= LEAST_PT - ROUNDING_PT, min(sizes)
    assert min(tampered)[0] < LEAST_PT
    assert min(scales) > 0.95


def test_printed_texts_have_seven_points(crank: str, tmp_path: Path) -> None:
    """The report of a mechanism with its drawing; tampered: tables in six points."""
    _, printed, refused = run("simulate", crank, "--out", str(tmp_path / "out"))
    assert printed, refused
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    count_sheets(page, tmp_path)
    sizes = read_font_sizes(tmp_path / "printed.pdf")
    assert len(sizes) > 5
    assert min(sizes) >= LEAST_PT - 0.5 / ZOOM
    small = "<style>td { font-size: 6pt !important; }</style></head>"
    count_sheets(page.replace("</head>", small, 1), tmp_path)
    assert min(read_font_sizes(tmp_path / "printed.pdf")) < LEAST_PT - 0.5 / ZOOM


def test_failures_open_the_page_with_value_and_angle(crank: str, tmp_path: Path) -> None:
    _, printed, _ = run("simulate", crank, "--out", str(tmp_path / "out"))
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    failure = page[page.index('class="failure"') :].partition("</p>")[0]
    assert re.search(r"abs F_Ax is [\d.]+ N at [\d.]+°, and must be at most 60 N", failure)
    assert page.index('class="failure"') < page.index('class="key-figures"')
    assert "Fails: abs F_Ax" in printed
