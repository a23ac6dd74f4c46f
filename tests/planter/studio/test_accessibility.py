"""The studio and reports for everyone: barriers in a browser, and all that a keyboard alone
does.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Literal

import pytest
from playwright.sync_api import Browser, Page, expect, sync_playwright

from tests.planter.studio.serving import studio
from tests.support import own
from tests.support.accessibility import list_barriers
from tests.support.browser import browser
from tests.support.cli import answer

MACHINES = ("wang2017-wide", "yu2023", "slider_crank.toml")
WIDTHS = (1280, 900, 390, 320)
SCHEMES: tuple[Literal["light", "dark"], ...] = ("light", "dark")
MISSING = "key: Stress needs [gears]"
"""A sentence that names what can be added to a file, by its keys."""
REPORTS = (
    ("simulate", "wang2017-wide"),
    ("diff", "wang2017", "wang2017-wide"),
    ("pickup", "yu2023"),
    ("clutch", "geometry", "shi2021"),
    ("synthesise", "sun2019-corrected"),
    ("audit", "wang2017"),
    ("explain", "wang2017"),
    ("optimise", "wang2017", "--method", "ipopt", "--starts", "2"),
    (
        "tolerance",
        "wang2017",
        "--samples",
        "1000",
        "--indices",
        "64",
        "--halved",
        "0",
        "--no-robust",
    ),
)
FAULTS = {
    "contrast": '<p style="color: #999">pale</p>',
    "name": "<button style='width: 30px; height: 30px'></button>",
    "target": "<button style='width: 10px; height: 10px; padding: 0'>x</button>",
    "table": "<table><tr><td>1</td></tr></table>",
    "key": "<p>R3_mm is too large</p>",
    "scrolls": "<div style='width: 3000px'>wide</div>",
}


@pytest.fixture(scope="module")
def chromium() -> Iterator[Browser]:
    path = browser()
    with (
        sync_playwright() as play,
        play.chromium.launch(executable_path=path, args=["--no-sandbox"]) as chromium,
    ):
        yield chromium


@contextmanager
def open_page(
    chromium: Browser, address: str, width: int, scheme: Literal["light", "dark"]
) -> Iterator[Page]:
    """A page in a window of a width, without motion."""
    context = chromium.new_context(
        viewport={"width": width, "height": 800}, color_scheme=scheme, reduced_motion="reduce"
    )
    page = context.new_page()
    page.goto(address)
    yield page
    context.close()


@contextmanager
def open_studio(chromium: Browser, folder: Path) -> Iterator[Page]:
    """The studio of a planting device in a wide window, once its details have arrived."""
    with (
        studio(folder, "wang2017-wide") as address,
        open_page(chromium, f"{address}#wang2017-wide", 1280, "light") as page,
    ):
        page.wait_for_selector("body[data-detailed]", timeout=60_000)
        yield page


@pytest.mark.parametrize("kind", FAULTS)
def test_every_kind_of_barrier_is_found(kind: str, chromium: Browser) -> None:
    page = chromium.new_page()
    good = "<p>good</p><button style='min-height: 30px'>go on</button>"
    page.set_content(f"<html lang='en'><body>{good}</body></html>")
    assert list_barriers(page) == []
    page.set_content(f"<html lang='en'><body>{good}{FAULTS[kind]}</body></html>")
    barriers = list_barriers(page)
    assert barriers
    assert all(barrier.startswith(kind) for barrier in barriers)
    page.close()


@pytest.mark.long
@pytest.mark.parametrize("machine", MACHINES)
def test_studio_has_no_barriers(machine: str, chromium: Browser, tmp_path: Path) -> None:
    """All parts open, with a design kept as B, at four widths in both schemes."""
    folder = own.generated(machine.removesuffix(".toml")) if machine.endswith(".toml") else None
    file = machine if folder is None else str(folder / machine)
    barriers = []
    with studio(tmp_path, file) as address:
        for scheme in SCHEMES:
            for width in WIDTHS:
                with open_page(chromium, f"{address}#{machine}", width, scheme) as page:
                    page.wait_for_selector("body[data-detailed]", timeout=60_000)
                    page.keyboard.press("k")
                    for panel in page.locator("#tabs button").all() if width < 700 else [None]:
                        if panel is not None:
                            panel.click()
                        page.evaluate(
                            "() => document.querySelectorAll('details').forEach((part) => "
                            "part.open = true)"
                        )
                        barriers += [
                            f"{width} {scheme}: {barrier}" for barrier in list_barriers(page)
                        ]
    assert [barrier for barrier in barriers if MISSING not in barrier] == []


@pytest.mark.long
@pytest.mark.parametrize("words", REPORTS)
def test_reports_have_no_barriers(
    words: tuple[str, ...], chromium: Browser, tmp_path: Path
) -> None:
    """But for keys, which a report explains beside their names."""
    answer(*words, "--out", str(tmp_path))
    barriers = []
    for scheme in SCHEMES:
        for width in WIDTHS:
            with open_page(chromium, (tmp_path / "report.html").as_uri(), width, scheme) as page:
                page.wait_for_timeout(300)
                barriers += [f"{width} {scheme}: {barrier}" for barrier in list_barriers(page)]
    assert [barrier for barrier in barriers if " key: " not in barrier] == []


def test_theme_is_chosen_and_survives_a_reload(chromium: Browser, tmp_path: Path) -> None:
    """The system's theme at first; another one from the keyboard, also after a reload; and back to
    the system's.
    """
    colour = "() => getComputedStyle(document.body).backgroundColor"
    with (
        studio(tmp_path, "wang2017-wide") as address,
        open_page(chromium, address, 1280, "dark") as page,
    ):
        dark = page.evaluate(colour)
        theme = page.get_by_label("Theme")
        expect(theme).to_have_value("")
        theme.focus()
        page.keyboard.press("ArrowDown")
        expect(theme).to_have_value("light")
        light = page.evaluate(colour)
        assert light != dark
        page.reload()
        expect(theme).to_have_value("light")
        assert page.evaluate(colour) == light
        page.emulate_media(color_scheme="light")
        theme.select_option("dark")
        assert page.evaluate(colour) == dark
        theme.select_option("")
        assert page.evaluate(colour) == light


@pytest.mark.long
def test_studio_fills_a_large_window(chromium: Browser, tmp_path: Path) -> None:
    """Panels scroll, and the page does not; drawing, curve and verdict are in sight together, also
    with two designs.
    """
    with open_studio(chromium, tmp_path) as page:
        page.keyboard.press("k")
        expect(page.locator("#drawings .ghost")).to_have_count(1)
        for part in ("#drawings svg.mechanism", "#drawings .controls", "#curve svg", "#verdict"):
            box = page.locator(part).bounding_box()
            assert box
            assert min(box["width"], box["height"]) > 100 or part == "#drawings .controls"
            assert box["x"] >= 0
            assert box["y"] >= 0
            assert box["x"] + box["width"] <= 1280
            assert box["y"] + box["height"] <= 800
        excess = "(part) => part.scrollHeight - part.clientHeight"
        assert page.locator("html").evaluate(excess) == 0
        assert page.locator("#told").evaluate(excess) > 0


@pytest.mark.long
def test_axe_finds_no_serious_violation(chromium: Browser, tmp_path: Path) -> None:
    """In both schemes, with the question before a search and all parts open."""
    script = Path(pytest.importorskip("axe_core_python").__file__).with_name("axe.min.js")
    folder, name = own.generated("slider_crank"), "slider_crank.toml"
    with studio(tmp_path, str(folder / name)) as address:
        for scheme in SCHEMES:
            context = chromium.new_context(color_scheme=scheme, bypass_csp=True)
            page = context.new_page()
            page.goto(f"{address}#{name}")
            page.wait_for_selector("body[data-detailed]", timeout=60_000)
            page.click("#optimise")
            page.wait_for_selector("#plan:not([hidden])", timeout=60_000)
            page.evaluate(
                "() => document.querySelectorAll('details').forEach((part) => part.open = true)"
            )
            page.evaluate(script.read_text(encoding="utf-8"))
            violations = page.evaluate("async () => (await axe.run(document)).violations")
            context.close()
            assert not [
                violation["id"]
                for violation in violations
                if violation["impact"] in ("serious", "critical")
            ]


@pytest.mark.long
def test_design_kept_as_b_survives_another_width(chromium: Browser, tmp_path: Path) -> None:
    with open_studio(chromium, tmp_path) as page:
        errors: list[str] = []
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.keyboard.press("k")
        page.set_viewport_size({"width": 600, "height": 800})
        expect(page.locator("#drawings .ghost")).to_have_count(1)
        page.wait_for_timeout(300)
        assert errors == []


@pytest.mark.long
def test_keyboard_alone_does_all(chromium: Browser, tmp_path: Path) -> None:
    """Each control is reached by Tab; values are typed, stepped, refused and undone; nothing moves
    by itself.
    """
    with open_studio(chromium, tmp_path) as page:
        expected = page.evaluate(
            "() => Array.from(document.querySelectorAll('button, input, select, summary'))"
            ".filter((part) => part.checkVisibility({ checkVisibilityCSS: true }) && "
            "!part.disabled).length"
        )
        reached = page.evaluate_handle("() => new Set()")
        for _ in range(expected + 20):
            page.keyboard.press("Tab")
            page.evaluate(
                "(all) => document.activeElement.matches('button, input, select, summary')"
                " && all.add(document.activeElement)",
                reached,
            )
        assert page.evaluate("(all) => all.size", reached) == expected
        field = page.get_by_label("Circle radius", exact=False).first
        field.focus()
        first = field.input_value()
        page.keyboard.press("ArrowUp")
        expect(field).not_to_have_value(first)
        page.keyboard.press("Control+z")
        expect(field).to_have_value(first)
        field.fill("30,5 mm")
        page.keyboard.press("Enter")
        expect(field).to_have_value("30.5")
        for text in ("99", "a lot", " "):
            field.fill(text)
            page.keyboard.press("Tab")
            expect(field).to_have_attribute("aria-invalid", "true")
            expect(page.locator("#said")).to_have_attribute("role", "alert")
            expect(page.locator("#said")).to_contain_text("Circle radius")
        expect(page.locator("#readings")).to_have_attribute("aria-busy", "false", timeout=60_000)
        picture_id = page.locator("body").get_attribute("data-shown")
        field.focus()
        page.keyboard.press("Escape")
        expect(field).to_have_value("30.5")
        expect(field).to_have_attribute("aria-invalid", "false")
        assert page.locator("body").get_attribute("data-shown") == picture_id
        page.keyboard.press("Control+z")
        expect(field).to_have_value(first)
        page.keyboard.press("Control+Shift+z")
        expect(field).to_have_value("30.5")
