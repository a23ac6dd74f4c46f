"""What goes wrong with a studio: nonsense, several pages, lines that break, a studio that is
started anew.
"""

from __future__ import annotations

import re
import socket
from contextlib import ExitStack
from importlib import resources
from pathlib import Path

import pytest
from playwright.sync_api import Page, WebSocketRoute, expect, sync_playwright

from planter import simulate
from planter.files.examples import example
from planter.papers.planting.file import load
from planter.papers.planting.model import Device
from planter.studio.process import to_page_words
from planter.studio.session import Session
from tests.planter.studio.serving import answer, line, message_with, page_of, studio
from tests.support.browser import browser

NONSENSE = (
    "no JSON",
    b"\xff\x00",
    "[1, 2]",
    "null",
    "[" * 100_000,
    '{"ask": {}}',
    '{"ask": "open", "text": 5}',
    '{"ask": "open"}',
    '{"id": 1, "values": 5}',
    '{"id": 1, "values": {"design.R3_mm": []}}',
    '{"id": 1, "values": {"R3": null}}',
    '{"id": 1, "values": {}, "model": {}}',
    '{"ask": "optimise", "values": 5}',
    '{"ask": "optimise", "model": "--help"}',
    '{"ask": "export", "names": 5}',
    '{"ask": "export", "names": [[]]}',
    '{"ask": "export", "names": ["cam"], "numbers": 5}',
    "[" * 3000 + "]" * 3000,
    '{"id": 1, "values": ' + '{"a":' * 3000 + "1" + "}" * 3001,
    '{"id": 1, "values": {"a": ' + "[" * 900 + "]" * 900 + "}}",
    '{"ask": "open", "text": "x = ' + "[" * 3000 + '"}',
    '{"ask": "open", "text": "x = ' + "a." * 900 + '"}',
    '{"ask": "open", "name": "a\\u0000b.toml"}',
    '{"ask": "open", "name": "\\ud800.toml"}',
    '{"ask": "open", "text": "a\\u0000b"}',
    '{"ask": "open", "text": "\\ud800 = 1"}',
    '{"ask": "\\ud800"}',
    '{"id": "\\ud800", "values": {"\\ud800": 1}}',
    '{"id": 1, "values": {"design.R3_mm": true}}',
    '{"ask": "open", "name": "' + "x" * 5000 + '.toml"}',
    '{"id": 1, "values": ' + "9" * 5000 + "}",
)
"""Messages that no page sends."""


def test_nonsense_is_refused_without_loss(address: str) -> None:
    with line(address) as talk:
        opened = answer(talk, "opened", ask="open", name="wang2017")
        for message in NONSENSE:
            talk.send(message)
            sentence = message_with(talk, "error")["error"]
            assert "\n" not in sentence
            assert "Traceback" not in sentence
        reply = answer(talk, "scenes", id=2, values={"design.R3_mm": 30.8})
        assert reply
        assert answer(talk, "file", ask="file", values={}).count(opened["name"])


def test_every_page_has_a_separate_machine(address: str) -> None:
    with line(address) as first, line(address) as second:
        answer(first, "opened", ask="open", name="wang2017")
        answer(second, "opened", ask="open", name="shi2021")
        assert "design" in answer(first, "file", ask="file", values={"design.R3_mm": 30.8})
        assert "sleeve" in answer(second, "file", ask="file", values={})


def settled(page: Page) -> str:
    """The first result of A once it is that of true extremes."""
    expect(page.locator("#readings")).to_have_attribute("aria-busy", "false", timeout=60_000)
    return page.locator("#readings tbody tr").first.locator("td").nth(0).inner_text()


def field(page: Page) -> str:
    return page.locator('[data-path="design.R3_mm"] input.value').input_value()


def test_broken_connection_recovers_without_loss(address: str) -> None:
    """As when a laptop sleeps: the page says so, comes back by itself, and goes on with the numbers
    that it had.
    """
    lines: list[WebSocketRoute] = []

    def through(route: WebSocketRoute) -> None:
        route.connect_to_server()
        lines.append(route)

    with page_of(
        address, "wang2017", lambda page: page.route_web_socket(re.compile("/live$"), through)
    ) as page:
        objective = page.locator("#readings tbody tr").first.locator("td").nth(0)
        first = settled(page)
        page.fill('[data-path="design.R3_mm"] input.value', "30.8")
        page.keyboard.press("Tab")
        expect(objective).not_to_have_text(first)
        moved, title = settled(page), str(page.locator("body").get_attribute("data-shown"))
        lines[0].close()
        expect(page.locator("#said")).to_have_text("The studio does not answer; trying again.")
        expect(page.locator("body")).not_to_have_attribute("data-shown", title, timeout=60_000)
        assert (field(page), settled(page), len(lines)) == ("30.8", moved, 2)
        expect(page.locator("#said")).to_have_text("")
        page.click("#undo")
        expect(objective).to_have_text(first)


@pytest.mark.long
def test_saved_copy_of_page_says_so(tmp_path: Path) -> None:
    for name in ("studio.html", "saved.js", "studio.js", "studio.css"):
        (tmp_path / name).write_bytes(resources.files("planter.studio").joinpath(name).read_bytes())
    with (
        sync_playwright() as play,
        play.chromium.launch(executable_path=browser(), args=["--no-sandbox"]) as chromium,
    ):
        page = chromium.new_page()
        page.goto((tmp_path / "studio.html").as_uri())
        expect(page.locator("#said")).to_contain_text("saved copy")
        assert page.locator("button:not(:disabled), select:not(:disabled)").count() == 0


def load_file(page: Page, name: str, text: str) -> None:
    page.set_input_files(
        "#load", {"name": name, "mimeType": "application/toml", "buffer": text.encode()}
    )


@pytest.mark.long
def test_loaded_file_replaces_everything(address: str) -> None:
    """A file of the same name with another number; then one that is not valid TOML, which changes
    nothing.
    """
    text = example("wang2017").replace("R3_mm = 30.916", "R3_mm = 30.7  ")
    assert text != example("wang2017")
    expected = simulate(Device(load("wang2017", {"design.R3_mm": 30.7}))).result
    with page_of(address, "wang2017") as page:
        for path, value in (("design.R3_mm", "30.8"), ("mass.planet_kg", "1.5")):
            page.fill(f'[data-path="{path}"] input.value', value)
            page.keyboard.press("Tab")
        page.click("#keep")
        load_file(page, "own.toml", text)
        force = (
            page.locator("#readings tbody tr", has_text="range of the support force")
            .locator("td")
            .nth(0)
        )
        expect(force).to_have_text(f"{expected.refined.range_N:.6g}", timeout=60_000)
        assert (field(page), page.locator("#undo").is_disabled()) == ("30.7", True)
        expect(page.locator("#source option:checked")).to_have_text("own.toml (loaded)")
        expect(page.locator("#drawings .ghost")).to_have_count(0)
        load_file(page, "bad.toml", text + "\nopen = [1,")
        expect(page.locator("#said")).to_contain_text(
            "bad.toml: end of document: this is not valid TOML"
        )
        page.fill('[data-path="design.R3_mm"] input.value', "30.53")
        page.keyboard.press("Tab")
        expect(force).not_to_have_text(f"{expected.refined.range_N:.6g}", timeout=60_000)
        assert page.locator("#said").inner_text() == ""


@pytest.mark.long
def test_reload_restores_moved_controls(address: str) -> None:
    """Machine, model, numbers and the steps back; numbers of a file that has changed since are its
    own.
    """
    with page_of(address, "wang2017") as page:
        page.select_option("#source", "wang2017-wide")
        expect(page.locator("body")).to_have_attribute(
            "data-shown", re.compile("[2-9]"), timeout=60_000
        )
        page.select_option("#model", "printed")
        page.fill('[data-path="design.R3_mm"] input.value', "30.8")
        page.keyboard.press("Tab")
        objective = page.locator("#readings tbody tr").first.locator("td").nth(0)
        page.wait_for_function("() => Number(document.body.dataset.shown) >= 4")
        moved = settled(page)
        page.reload()
        expect(objective).to_have_text(moved, timeout=60_000)
        chosen = [page.locator(name).input_value() for name in ("#source", "#model")]
        assert (field(page), chosen) == ("30.8", ["wang2017-wide", "printed"])
        page.click("#undo")
        expect(objective).not_to_have_text(moved)
        page.evaluate("""() => addEventListener("pagehide", () => {
            const key = `planter studio ${location.pathname}`, kept = JSON.parse(sessionStorage.getItem(key));
            kept.own["design.R3_mm"] = 30.9;
            sessionStorage.setItem(key, JSON.stringify(kept));
        })""")
        page.fill('[data-path="design.R3_mm"] input.value', "30.8")
        page.keyboard.press("Tab")
        page.reload()
        expect(page.locator("#said")).to_contain_text("other numbers than before", timeout=60_000)
        assert field(page) != "30.8"


@pytest.mark.long
def test_page_reports_restarted_studio(tmp_path: Path) -> None:
    """It tells where to go on, and what was moved."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = str(free.getsockname()[1])
    with ExitStack() as pages:
        with studio(tmp_path, "shi2021", "--port", port) as address:
            page = pages.enter_context(page_of(address, "shi2021"))
            page.fill('[data-path="sleeve.travel_mm"] input.value', "4.5")
            page.keyboard.press("Tab")
        with studio(tmp_path, "shi2021", "--port", port):
            expect(page.locator("#said")).to_contain_text(
                "was started anew: open the address", timeout=60_000
            )
            expect(page.locator("#said")).to_contain_text("What was moved here: Travel = 4.5.")


def test_messages_of_a_search_have_words_of_the_page(tmp_path: Path) -> None:
    session = Session(tmp_path, tmp_path / "scratch")
    session.open({"name": "wang2017-wide"})
    labels = session.search({"values": {}})["labels"]
    sentence = (
        "the closest design violates: nozzle_distance = 59.2 mm at phi = 160.16 deg misses "
        "nozzle_distance_min_mm"
    )
    assert to_page_words(sentence, labels) == (
        "the closest design violates: Gap between the nozzles = 59.2 mm at phi = 160.16° misses "
        "its least allowed value"
    )
    assert to_page_words("own_nozzle_distance", labels) == "own_nozzle_distance"
