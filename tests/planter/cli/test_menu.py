"""The program's commands: sections and groups of its help, and earlier names, which answer as the
present ones do.
"""

from __future__ import annotations

import json
import re

import pytest
import typer

from planter import menu
from planter.cli.app import build_application
from tests.support.cli import answer, refusal, run

SMALL = ("--samples", "24")
CASES = {
    "turn wang2017 --samples 24": "simulate wang2017 --samples 24",
    "validate wang2017": "simulate wang2017 --check",
    "drive wang2017 --stall-Nm 6 --idle-rpm 42 --flywheel-kgm2 0.4 --samples 36 --turns 1": (
        "simulate wang2017 --motor --stall-Nm 6 --idle-rpm 42 --flywheel-kgm2 0.4 --samples 36 "
        "--turns 1"
    ),
    "clutch rotor": "design clutch rotor",
    "clutch plan L9 --seed 3": "design clutch plan L9 --seed 3",
    "pickup yu2023": "design pickup yu2023",
    "train sun2019-curve": "design train sun2019-curve",
    "synthesise sun2019-corrected": "design synthesise sun2019-corrected",
    "schema simulate": "about schema simulate",
    "cite optimise": "about cite optimise",
    "explain F_E": "about explain F_E",
}
"""Calls by an earlier name, each with the same call by the present one."""


def list_sections(*group: str) -> dict[str, dict[str, str]]:
    """Summaries of the commands of a help by section and name."""
    sections: dict[str, dict[str, str]] = {}
    title = ""
    for line in run(*group, "--help")[1].splitlines():
        if line.endswith(":") and not line.startswith(" "):
            title = line.removesuffix(":")
        elif title not in ("", "Options") and line.startswith("  "):
            name, summary = line.split(maxsplit=1)
            sections.setdefault(title, {})[name] = summary
    return sections


def test_help_has_every_command_in_its_section() -> None:
    sections = list_sections()
    (summary,) = sections.pop("More").values()
    assert summary.endswith(f"also {', '.join(menu.MORE)}.")
    assert {title: tuple(rows) for title, rows in sections.items()} == menu.SECTIONS
    for group, entry in menu.GROUPS.items():
        assert {name for rows in list_sections(group).values() for name in rows} == {
            *entry.commands
        }


def test_unlisted_command_is_in_the_last_line(monkeypatch: pytest.MonkeyPatch) -> None:
    """As those of installed packages are."""
    monkeypatch.setitem(menu.SECTIONS, "Study", ("sweep",))
    command = typer.main.get_command(build_application())
    text = command.get_help(typer.Context(command, info_name="planter"))
    assert "diff" in text.partition("More:")[2]
    assert "sweep" not in text.partition("More:")[2]


@pytest.mark.parametrize("group", [(), ("design",), ("about",), ("design", "clutch"), ("export",)])
def test_summaries_of_commands_are_whole_sentences(group: tuple[str, ...]) -> None:
    summaries = {
        name: text for rows in list_sections(*group).values() for name, text in rows.items()
    }
    assert len(summaries) > 3
    assert not {
        name: text
        for name, text in summaries.items()
        if not text.endswith(".") or text.endswith("...")
    }


def test_page_of_commands_has_all_with_their_summaries() -> None:
    """Those of the sections, of the line below them, and of their groups."""
    text = answer("help commands")["text"]
    calls = dict(re.findall(r"^    planter (.+?)  +(.+)$", text, re.MULTILINE))
    sections = [rows for title, rows in list_sections().items() if title != "More"]
    summaries = {name: row for rows in sections for name, row in rows.items()}
    assert summaries.items() <= calls.items()
    members = {f"{group} {name}" for group, entry in menu.GROUPS.items() for name in entry.commands}
    assert calls.keys() >= members | {*menu.MORE, "design clutch rotor", "export fmu"}


@pytest.mark.parametrize("earlier", CASES)
def test_earlier_name_answers_as_the_present_one(earlier: str) -> None:
    """Standard output is the same, and one line on standard error names the present command."""
    code, out, err = run(earlier, "--json")
    present_code, present_out, present_err = run(CASES[earlier], "--json")
    assert (code, json.loads(out)) == (present_code, json.loads(present_out))
    name = earlier.split(maxsplit=1)[0]
    note = f"planter: `planter {name}` is now `planter {menu.RENAMED[name]}`\n"
    assert err.endswith(note)
    assert err.removesuffix(note) == present_err


@pytest.mark.parametrize("name", [*menu.RENAMED])
def test_earlier_name_has_the_help_of_the_present_one(name: str) -> None:
    words = [word for word in menu.current_words([name]) if not word.startswith("--")]
    assert run(name, "--help")[1] == run(*words, "--help")[1]


@pytest.mark.parametrize("name", menu.SHORT)
def test_short_names_answer_without_a_note(name: str) -> None:
    code, out, err = run(name, "--json")
    assert (code, err) == (0, "")
    assert json.loads(out)


def test_error_stands_alone() -> None:
    assert refusal("validate nothing.toml").startswith("planter: nothing.toml")
    assert refusal("drive wang2017") == "planter: --motor needs --stall-Nm"
    assert refusal("turns wang2017").startswith("planter: No such command 'turns'")


@pytest.mark.parametrize(
    ("call", "words"),
    [
        ("simulate wang2017 --check --at 3", "--at has no effect with --check"),
        ("simulate wang2017 --check --motor", "--motor has no effect with --check"),
        ("simulate wang2017 --motor --at 3", "--at has no effect with --motor"),
        ("simulate wang2017 --turns 3", "--turns has no effect without --motor"),
        ("simulate wang2017 --until 3", "--until has no effect since an angle drives"),
        ("simulate wang2017 --seed 3", "--seed has no effect without --ensemble"),
        ("simulate nothing.toml --until 3", "nothing.toml"),
        ("optimise wang2017 --pair sine+sine", "--pair has no effect without --all-pairs"),
        ("optimise wang2017 --all-pairs --front", "--front has no effect with --all-pairs"),
        ("optimise wang2017 --all-pairs --pair sine", "--pair sine: it must be two of"),
    ],
)
def test_option_of_another_mode_is_refused(call: str, words: str) -> None:
    assert words in refusal(call)


def test_results_and_works_have_present_names() -> None:
    assert answer("about schema design clutch rotor") == answer("schema clutch rotor")
    assert answer("about schema")["commands"] == answer("schema")["commands"]
    assert answer("cite drive")["works"] == answer("about cite simulate motor")["works"]
