"""What the studio writes: what the commands write, below its folder and nowhere else."""

from __future__ import annotations

import json
import urllib.error
import urllib.request
from pathlib import Path
from typing import Any

import pytest
import typer
from playwright.sync_api import expect
from websockets.sync.client import ClientConnection

from planter.cli.app import build_application
from planter.errors import InputError
from planter.report.subject import open_machine
from planter.studio.process import export_path, find_export
from planter.studio.session import Session
from tests.planter.studio.serving import answer, line, open_line, page_of, until
from tests.support.cli import answer as command

MACHINES = ("wang2017", "yu2023", "shi2021", "sun2019-corrected")
VALUES = {"design.R3_mm": 30.8, "operation.speed_rpm": 38.0}


def fetched(address: str) -> tuple[int, bytes, str]:
    """Status, content and policy of what stands at an address."""
    try:
        with urllib.request.urlopen(address, timeout=10) as response:
            return response.status, response.read(), response.headers["content-security-policy"]
    except urllib.error.HTTPError as error:
        return error.code, b"", ""


def exported(talk: ClientConnection, **message: Any) -> list[dict[str, Any]]:
    """The files of one export."""
    talk.send(json.dumps({"ask": "export", "values": {}, **message}))
    return until(talk, "files", "error")


@pytest.fixture(scope="module")
def motion(address: str) -> list[dict[str, Any]]:
    """The files of a machine's motion, other numbers set."""
    with open_line(address, "wang2017") as talk:
        return exported(talk, names=["motion-csv"], values=VALUES, model="printed")


def test_export_equals_command(motion: list[dict[str, Any]], folder: Path, tmp_path: Path) -> None:
    changes = [word for name, value in VALUES.items() for word in ("--set", f"{name}={value}")]
    command("export motion wang2017", *changes, "--model", "printed", "--out", str(tmp_path))
    expected, motion_folder = (
        folder / "exports" / "wang2017" / "motion-csv",
        {path.name: path for path in tmp_path.glob("[!.]*")},
    )
    assert {Path(entry["path"]).name for entry in motion} == motion_folder.keys()
    table = next(name for name in motion_folder if name.endswith(".csv"))
    assert (expected / table).read_text().splitlines()[-361:] == motion_folder[
        table
    ].read_text().splitlines()[-361:]


def test_exports_leave_the_files_of_the_user(
    address: str, folder: Path, motion: list[dict[str, Any]]
) -> None:
    """Notes in the folder of an export stay, and are not offered as its files."""
    notes = folder / "exports" / "wang2017" / "motion-csv" / "notes.txt"
    notes.write_text("mine", encoding="utf-8")
    with open_line(address, "wang2017") as talk:
        again = exported(talk, names=["motion-csv"], values=VALUES, model="printed")
    assert notes.read_text(encoding="utf-8") == "mine"
    assert {entry["path"] for entry in again} == {entry["path"] for entry in motion}


def test_an_edited_file_of_a_machine_is_not_replaced(tmp_path: Path) -> None:
    """One that the studio wrote is; the refusal does not speak of options."""
    session, edited = (
        Session(tmp_path, tmp_path / "scratch"),
        tmp_path / "exports" / "shi2021" / "machine.toml",
    )
    session.open({"name": "shi2021"})
    for travel in (4.2, 4.5):
        session.works({"names": ["animation"], "values": {"sleeve.travel_mm": travel}})
    edited.write_text("mine", encoding="utf-8")
    with pytest.raises(InputError, match="did not write") as refused:
        session.works({"names": ["animation"]})
    assert "--" not in session.in_page_words(refused.value)
    assert edited.read_text(encoding="utf-8") == "mine"


@pytest.mark.parametrize("place", ["shi2021", "shi2021/animation"])
def test_a_file_in_the_place_of_a_folder_is_reported(
    address: str, folder: Path, place: str
) -> None:
    standing = folder / "exports" / place
    standing.parent.mkdir(parents=True, exist_ok=True)
    standing.write_text("mine", encoding="utf-8")
    with open_line(address, "shi2021") as talk:
        sentence = exported(talk, names=["animation"])
        assert isinstance(sentence, str)
        assert str(standing) in sentence
        assert answer(talk, "file", ask="file", values={})
    assert standing.read_text(encoding="utf-8") == "mine"
    standing.unlink()


def test_only_exported_files_can_be_fetched(
    address: str, folder: Path, motion: list[dict[str, Any]]
) -> None:
    (folder / "secret.toml").write_text("name = 'own'", encoding="utf-8")
    for entry in motion:
        status, content, policy = fetched(f"{address}exports/{entry['path']}")
        assert (status, len(content)) == (200, entry["bytes"])
        assert policy.startswith("sandbox")
    outside = (
        "../secret.toml",
        "..%2fsecret.toml",
        "%2e%2e/secret.toml",
        "wang2017/../../secret.toml",
        "/etc/passwd",
        "",
    )
    assert {fetched(f"{address}exports/{path}")[0] for path in outside} <= {403, 404}


def test_an_export_can_be_given_up(address: str) -> None:
    with open_line(address, "wang2017") as talk:
        assert answer(talk, "exporting", ask="export", values={}, names=["optimum"]) == ""
        assert until(talk, "exporting") == "optimum"
        talk.send(json.dumps({"ask": "cancel", "work": "export"}))
        assert answer(talk, "file", ask="file", values={}).startswith("# The machine")


@pytest.mark.parametrize(
    ("message", "sentence"),
    [
        (
            {"names": ["../report"]},
            r"^\.\./report: there is no such export; choose one of report, optimum, gears",
        ),
        (
            {"names": ["cam"], "numbers": {"--roller-mm": None}},
            "radius of the roller.* = null: a positive number",
        ),
        (
            {"names": ["cam"], "numbers": {"--roller-mm": float("inf")}},
            "radius of the roller.* = inf: a positive number",
        ),
        ({"names": ["report"], "values": {"design.R3_mm": 0}}, "must be between"),
    ],
)
def test_unoffered_export_is_not_written(
    tmp_path: Path, message: dict[str, Any], sentence: str
) -> None:
    session = Session(tmp_path, tmp_path / "scratch")
    session.open({"name": "wang2017"})
    with pytest.raises(InputError, match=sentence):
        session.works(message)


def test_a_name_of_a_machine_is_no_path_and_a_link_leads_nowhere(tmp_path: Path) -> None:
    studio, outside = tmp_path / "studio", tmp_path / "outside"
    studio.mkdir()
    outside.mkdir()
    (outside / "report.html").write_text("", encoding="utf-8")
    assert export_path(studio, "../../etc", "report").resolve().is_relative_to(studio)
    (studio / "exports").symlink_to(outside)
    assert find_export(studio, "report.html") is None
    with pytest.raises(InputError, match="a link leads out"):
        export_path(studio, "own", "report")


@pytest.mark.parametrize("source", MACHINES)
def test_offered_exports_are_commands(source: str, tmp_path: Path) -> None:
    """Their words name a command, and its options are among those of the command."""
    for export in open_machine(source).exports:
        command = typer.main.get_command(build_application())
        for word in export.words:
            command = command.commands[word]  # type: ignore[attr-defined]
        options = {option for parameter in command.params for option in parameter.opts}
        command_line = export.command(tmp_path / "own.toml", tmp_path, "exact", {})
        assert {word for word in command_line if word.startswith("--")} <= options


@pytest.mark.long
@pytest.mark.parametrize("source", MACHINES)
def test_every_offered_export_is_written(source: str, address: str) -> None:
    with line(address) as talk:
        offered = answer(talk, "opened", ask="open", name=source)["exports"]
        for offer in offered:
            files = exported(talk, names=[offer["name"]])
            assert isinstance(files, list), (offer["name"], files)
            assert files
            assert all(file["bytes"] for file in files)


@pytest.mark.long
def test_page_writes_and_links_selected_exports(address: str) -> None:
    with page_of(address, "wang2017") as page:
        page.get_by_text("Write files").click()
        page.get_by_label("cam:").check()
        page.get_by_label("radius of the roller").fill("6")
        page.get_by_role("button", name="Write").click()
        drawing_link = page.locator("#written a", has_text=".dxf").first
        expect(drawing_link).to_be_visible(timeout=60_000)
        expect(page.locator("#export")).to_have_text("Write", timeout=60_000)
        page.get_by_label("cam:").uncheck()
        page.get_by_label("report:").check()
        page.get_by_role("button", name="Write").click()
        link = page.locator("#written a", has_text="report.html")
        expect(link).to_be_visible(timeout=60_000)
        with page.expect_popup() as popup:
            link.click()
        report = popup.value
        expect(report.locator(".told")).to_contain_text("carrier angle 0\N{DEGREE SIGN}")
        assert report.evaluate("origin") == "null"
