"""`generated/`: reproducible to the byte, compared both ways, no larger than its baseline.

The suite derives a part of it again; `make check-generated` and the long tests derive all.
"""

import hashlib
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from derive.emit.folder import built_in, render_texts, select_targets
from derive.generated_folder import GENERATED, list_changes, list_differences, write_folder
from derive.generation import VERDICTS, derive_code, derive_models
from derive.mechanics.gearing.families import FAMILIES
from derive.papers import disc_cam
from derive.papers.clutch import contacts
from derive.papers.planting import derivation

ROOT = Path(__file__).parents[3]
BASELINE = json.loads((Path(__file__).parent / "operations.json").read_text())
PRINT_HASH = """
import hashlib
from derive.generation import VERDICTS, code
print(hashlib.sha256(repr(sorted(code().items())).encode()).hexdigest())
"""


SAMPLE = (disc_cam, contacts, derivation)
"""Models that are derived quickly."""


@pytest.fixture(scope="module")
def content() -> dict[str, str]:
    """What stands there, but for the verdicts."""
    paths = (p for p in GENERATED.rglob("*.*") if p.suffix != ".pyc")
    texts = {p.relative_to(GENERATED).as_posix(): p.read_bytes().decode() for p in paths}
    return {name: text for name, text in texts.items() if name not in VERDICTS}


def test_a_part_is_up_to_date() -> None:
    derived = render_texts(derive_models(SAMPLE), [FAMILIES["ellipse"]], select_targets(built_in()))
    assert {
        "disc_cam.py",
        "clutch_contact_dog.json",
        "array/planting_exact.py",
        "curve_ellipse.py",
    } <= derived.keys()
    assert list_changes(GENERATED, derived) == []


@pytest.mark.long
def test_generated_is_up_to_date() -> None:
    assert [
        d
        for d in list_differences(GENERATED, derive_code())
        if d.removeprefix("stray: ") not in VERDICTS
    ] == []


def test_written_folder_compares_equal(content: dict[str, str], tmp_path: Path) -> None:
    write_folder(tmp_path, content)
    assert list_differences(tmp_path, content) == []


def test_changed_missing_and_stray_files_are_listed(
    content: dict[str, str], tmp_path: Path
) -> None:
    write_folder(tmp_path, content)
    name = "planting_exact.py"
    (tmp_path / name).write_text(content[name].replace("m_C1", "m_C2", 1))
    (tmp_path / "curve_ellipse.json").unlink()
    (tmp_path / "notes.txt").write_text("stray")
    assert list_differences(tmp_path, content) == [
        "stray: notes.txt",
        "missing: curve_ellipse.json",
        f"changed: {name}",
    ]


def test_writing_removes_strays(content: dict[str, str], tmp_path: Path) -> None:
    (tmp_path / "old_model.py").write_text("left over")
    write_folder(tmp_path, content)
    assert not (tmp_path / "old_model.py").exists()


@pytest.mark.long
@pytest.mark.parametrize("seed", ["1", "20171"])
def test_text_does_not_depend_on_the_hash_seed(seed: str) -> None:
    digest = hashlib.sha256(repr(sorted(derive_code().items())).encode()).hexdigest()
    process = subprocess.run(
        [sys.executable, "-c", PRINT_HASH],
        cwd=ROOT,
        env=os.environ | {"PYTHONHASHSEED": seed},
        capture_output=True,
        text=True,
        check=True,
    )
    assert process.stdout.strip() == digest


def grown(content: dict[str, str]) -> list[str]:
    """Functions with more operations than the baseline."""
    larger = []
    for name, baseline in BASELINE.items():
        functions = json.loads(content[f"{name}.json"])["functions"]
        larger += [
            f"{name}.{f}" for f, limit in baseline.items() if functions[f]["operations"] > limit
        ]
    return larger


def test_no_kernel_has_grown(content: dict[str, str]) -> None:
    assert {
        name.removesuffix(".json") for name in content if name.endswith(".json")
    } == BASELINE.keys()
    assert grown(content) == []


def test_a_grown_kernel_is_noticed(content: dict[str, str]) -> None:
    sidecar = json.loads(content["planting_exact.json"])
    sidecar["functions"]["lane"]["operations"] += 1
    assert grown({**content, "planting_exact.json": json.dumps(sidecar)}) == ["planting_exact.lane"]


@pytest.mark.parametrize("name", ["planting_exact.py", "planting_printed.py", "curve_ellipse.py"])
def test_modules_have_a_describing_header(name: str, content: dict[str, str]) -> None:
    head = content[name].split('"""')[1]
    assert "do not edit" in head
    assert "[m]" in head
    compile(content[name], name, "exec")


def test_printed_steps_carry_their_equation_numbers(content: dict[str, str]) -> None:
    text = content["planting_printed.py"]
    assert all(
        f"# wang2017 ({n})\n" in text
        for n in (1, 2, 5, 8, 9, 14, 15, 17, 18, 20, 21, 23, 24, 25, 28)
    )
