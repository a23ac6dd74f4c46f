"""The documentation: every public name on its page, examples that run, findings that say what the
records say.
"""

from __future__ import annotations

import copy
import re
import shutil
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import derive
import planter
from planter import menu
from planter.audit import verdicts
from planter.cli import dictionary
from planter.cli.references import load_references
from planter.kernels import generated
from tests.support.cli import run
from tests.support.structure import ROOT

DOCS = ROOT / "docs"
STUDY = DOCS / "studies" / "wang2017.md"
GALLERY = sorted(path for path in (DOCS / "gallery").glob("*.md") if path.stem != "index")
RUN = [*GALLERY, STUDY]
"""Pages whose cells run."""
WITH_PROCESSES = {
    "design_and_trajectory",
    "embedding",
    "free_motion",
    "gears_to_cut",
    "library",
    "measured",
    "optimal_control",
    "own_mechanism",
    "own_paper",
    "tolerance",
    "wang2017",
}
"""Pages that start commands, or searches, for some seconds."""
LONGER = (
    "--prove",
    "--front",
    "--lift",
    "--step",
    "--cluster",
    "hybrid",
    "optimise wang2017-wide",
    "contact",
    "animate",
    "bench",
    "calibrate",
    "compare",
    "drive",
    "export",
    "gears",
    "optimise own",
    "studio",
    "sweep",
    "tolerance",
)
"""What takes minutes, or never ends, and what goes on from there; tests of their own run these."""


PAGES = sorted([ROOT / "README.md", ROOT / "CONTRIBUTING.md", *DOCS.glob("*.md")])

sys.path.insert(0, str(DOCS))

from book import (  # noqa: E402
    commands,
    drawings,
    figures,
    findings,
    formats,
    keys,
    models,
    names,
    reference,
    thumbnails,
    works,
)


def cells(page: Path) -> list[str]:
    """Code cells of a page of the gallery."""
    return re.findall(
        r"^```\{code-cell\}\n(.*?)^```$", page.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL
    )


def typed(text: str) -> Iterator[tuple[list[str], str | None]]:
    """Calls of a page's indented blocks as words, each with the file that its output goes into."""
    for line in text.splitlines():
        if re.match(r" {4}planter [a-z]", line):
            call, _, target = line.partition("#")[0].partition(">")
            yield re.findall(r'"[^"]*"|\S+', call)[1:], target.strip() or None


def tables(text: str) -> Iterator[str]:
    """Indented blocks that are parts of a machine's file."""
    for block in text.split("\n\n"):
        if re.match(r" {4}(\[\w+\]|\w+ = [\[\d\"-])", block):
            yield "\n".join(line.removeprefix("    ") for line in block.strip("\n").splitlines())


@pytest.fixture(scope="module")
def helps() -> dict[str, str]:
    return dict(commands.texts())


def unknown(words: list[str], helps: dict[str, str]) -> list[str]:
    """What a call names that there is not: the command, by an earlier name too, or options of it."""
    present = menu.current_words(words)
    names = (" ".join(present[:count]) for count in (3, 2, 1))
    name = next((index for index in names if index in helps), None)
    if name is None:
        return words[:1]
    return [
        word
        for word in words
        if word.startswith("--") and not re.search(rf"{word}\b", helps[name] + "--version")
    ]


@pytest.mark.parametrize(
    "page",
    [
        pytest.param(page, marks=pytest.mark.long if page.stem in WITH_PROCESSES else ())
        for page in RUN
    ],
    ids=[page.stem for page in RUN],
)
def test_the_gallery_runs(
    page: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("MPLBACKEND", "Agg")
    monkeypatch.chdir(page.parent)
    space: dict[str, object] = {}
    outputs = cells(page)
    assert outputs
    for cell in outputs:
        exec(compile(cell, page.name, "exec"), space)


def test_record_of_the_study_equals_its_inputs(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without its searches, which `test_the_gallery_runs` has."""
    monkeypatch.setenv("MPLBACKEND", "Agg")
    monkeypatch.chdir(STUDY.parent)
    space: dict[str, Any] = {}
    outputs = cells(STUDY)
    set_up, inputs, recorded, speeds = (outputs[index] for index in (0, 1, 3, 7))
    for cell in (set_up, inputs, recorded, speeds):
        exec(compile(cell, STUDY.name, "exec"), space)
    rows = {"constant_speed": "steady", "rippling_speed": "rippling", "backlash": "backlash"}
    for key, name in rows.items():
        for row, expected in zip(space[name], space["record"][key], strict=True):
            for part, value in expected.items():
                assert row[part] == (value if part == "mesh" else pytest.approx(value, rel=1e-6))
    point = space["record"]["fits"]["exact"]
    with pytest.raises(AssertionError):
        space["check"]({**point, "range_N": point["range_N"] + 1}, "exact")


@pytest.mark.parametrize("page", PAGES, ids=[page.stem for page in PAGES])
def test_commands_and_options_on_pages_exist(page: Path, helps: dict[str, str]) -> None:
    for words, _ in typed(page.read_text(encoding="utf-8")):
        assert not unknown(words, helps), words


def test_calls_in_table_of_tasks_exist(helps: dict[str, str]) -> None:
    rows = re.findall(r"^\|.*\|$", (DOCS / "start.md").read_text(encoding="utf-8"), re.MULTILINE)
    calls = [call for row in rows for call in re.findall(r"`planter ([^`]+)`", row)]
    assert len(calls) > 12
    for call in calls:
        assert not unknown(call.split(), helps), call


def test_unknown_command_or_option_is_detected(helps: dict[str, str]) -> None:
    assert unknown(["simulat", "wang2017"], helps) == ["simulat"]
    assert unknown(["simulate", "wang2017", "--att", "0"], helps) == ["--att"]


@pytest.mark.long
@pytest.mark.parametrize("page", PAGES, ids=[page.stem for page in PAGES])
def test_commands_on_pages_run(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.copytree(DOCS / "examples", tmp_path / "docs" / "examples")
    monkeypatch.chdir(tmp_path)
    left = set(LONGER)
    for words, target in typed(page.read_text(encoding="utf-8")):
        if any(part in " ".join(words) for part in left):
            left |= {f"{words[words.index('--out') + 1]}/"} if "--out" in words else set()
            continue
        code, out, err = run(*(word.strip('"') for word in words))
        assert code == 0, (words, err)
        if target is not None:
            Path(target).write_text(out, encoding="utf-8")


def test_tables_on_pages_are_read() -> None:
    blocks = [block for page in PAGES for block in tables(page.read_text(encoding="utf-8"))]
    assert blocks
    for block in blocks:
        assert tomllib.loads(block)


def test_calls_and_tables_are_recognised() -> None:
    text = (
        'Take\n\n    planter example a > b.toml   # one\n    planter turn b --least "range '
        'F"\n\n    [law]\n    p = 1\n'
    )
    assert list(typed(text)) == [
        (["example", "a"], "b.toml"),
        (["turn", "b", "--least", '"range F"'], None),
    ]
    assert list(tables(text)) == ["[law]\np = 1"]


def test_every_command_has_a_page(helps: dict[str, str]) -> None:
    listed = {name for names in menu.SECTIONS.values() for name in names}
    assert {name.split()[0] for name in helps} == listed | {*menu.MORE}


def test_every_column_is_documented() -> None:
    page = formats.page()
    assert not [
        meaning.name
        for meaning in dictionary.collect_meanings()
        if meaning.kind == "column" and f"| `{meaning.name}` |" not in page
    ]


def test_every_command_has_an_existing_example(helps: dict[str, str]) -> None:
    calls, printed = commands.examples()
    assert calls.keys() == helps.keys()
    assert printed < calls.keys()
    for words, call in calls.items():
        assert call.split()[1:][: len(words.split())] == words.split()
        assert not unknown(call.split()[1:], helps), call


def test_example_output_is_shown() -> None:
    assert commands.printed("planter explain F_E").startswith("F_E [N], symbol, planting")
    with pytest.raises(RuntimeError, match="NAME = F_Ezz"):
        commands.printed("planter explain F_Ezz")


@pytest.mark.long
def test_every_shown_example_runs() -> None:
    assert commands.page().count("$ planter ") == len(commands.examples()[0])


def test_every_public_name_is_documented() -> None:
    page = names.page() + "".join(map(reference.page, reference.PAGES))
    for package in (planter, derive):
        for name, member in names.public(package).items():
            assert page.count(f":: {package.__name__}.{name}\n") == 1
            assert not callable(member) or member.__doc__, name


def test_every_file_key_is_documented() -> None:
    page = keys.page()
    assert "| `mass.sun_kg` | kg | mass of the sun | greater than 0 | 0.4 | assumed |" in page
    assert "| `cam.rise_delta_deg` | deg |" in page
    assert "| 130, 180 | assumed |" in page
    file_keys = {
        meaning.key for meaning in dictionary.collect_meanings() if meaning.kind == "file key"
    }
    assert not [key for key in file_keys if f"| `{key}` |" not in page]


def test_drawings_have_a_row_for_every_symbol_on_them() -> None:
    page = drawings.page()
    for machine in drawings.machines().values():
        for sheet in machine.sheets:
            assert f"{{figure}} {machine.kind}-{sheet.name}.svg\n" in page
            assert all(f"| `{symbol.name}` |" in page for symbol in sheet.symbols)
    assert "| `a1` | centre distance of stage 1" in page


def test_every_model_is_documented_with_assumptions() -> None:
    page = models.page()
    assert set(generated.names()) - set(models.names()) == {"audit", "audit_mathml", "verdicts"}
    for name in models.names():
        assert f"## `{name}`\n" in page
        assert all(
            f"* {assumption}" in page
            for assumption in generated.sidecar(name).get("assumptions", ())
        )


def test_figures_on_pages_are_generated() -> None:
    text = "".join(path.read_text(encoding="utf-8") for path in DOCS.glob("*.md"))
    assert set(re.findall(r"\(made/theory-(\w+)\.svg\)", text)) == figures.FIGURES.keys()


def test_every_work_is_documented_with_doi() -> None:
    page = works.page()
    for key, fields in load_references().works.items():
        assert fields["title"].replace("^", "\\^") in page, key
        assert "doi" not in fields or f"(https://doi.org/{fields['doi']})" in page


def test_findings_name_every_equation_at_fault_and_no_other() -> None:
    record, page = verdicts.load_verdicts(), findings.page()
    listed = set(re.findall(r"^\* \*\*\((.+?)\)\*\*, ", page, re.MULTILINE))
    assert listed == {
        entry["equation"] for entry in record["equations"] if entry["grade"] == "at fault"
    }


def test_findings_name_their_conditions() -> None:
    record: dict[str, Any] = copy.deepcopy(dict(verdicts.load_verdicts()))
    at_fault = next(
        entry
        for entry in record["equations"]
        if entry["verdict"] == "misprint" and not entry["fragile"]
    )
    before = findings.page(record).count("one character of the text as read")
    assert before == sum(
        findings.page(record).count(f"**({entry['equation']})**, {entry['claims']}")
        for entry in record["equations"]
        if entry["fragile"] and entry["verdict"] in findings.FAULT
    )
    at_fault["fragile"] = True
    assert findings.page(record).count("one character of the text as read") > before
    lacking = next(
        entry
        for entry in record["equations"]
        if entry["verdict"] == "incomplete" and entry["terms"]
    )
    lacking["terms"] = [dict(term, share_of_largest=0.5) for term in lacking["terms"]]
    assert not findings.negligible(lacking)
    lacking["terms"][0]["share_of_largest"] = 0.001
    assert findings.negligible(lacking) == (len(lacking["terms"]) == 1)
    at_fault["verdict"] = "confirmed"
    assert f"**({at_fault['equation']})**, {at_fault['claims']}" not in findings.page(record)


def test_gallery_has_small_thumbnails_of_its_pages(tmp_path: Path) -> None:
    thumbnails.draw_thumbnails(tmp_path)
    pictures = {path.stem.removeprefix("gallery-"): path for path in tmp_path.iterdir()}
    index = (DOCS / "gallery" / "index.md").read_text(encoding="utf-8")
    links = re.findall(r"made/gallery-(\w+)\.svg\)\n[^\]]+\]\((\w+)\.md\)", index)
    assert len(links) == 8
    assert sorted(links) == sorted((page, page) for page in pictures)
    assert {page.stem for page in GALLERY} > set(pictures)
    for path in pictures.values():
        text = path.read_text(encoding="utf-8")
        assert len(text) < 6000
        assert text.count("<path") >= 2
