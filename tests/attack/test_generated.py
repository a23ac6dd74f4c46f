"""Generated modules and sidecars that were emptied, cut or edited end in one sentence that says
what to run.
"""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

import pytest
from hypothesis import given, seed
from hypothesis import strategies as st

from planter.kernels import formulas, generated
from tests.attack.test_attack import SEED, assert_ends_properly, share
from tests.support import own
from tests.support.cli import refusal, run

NAMES = {"slider_crank": ("simulate",), "gear_rattle": ("move", "--until", "0.01", "--points", "5")}


def copy(name: str) -> Path:
    """Return a folder with a copy of what is generated of a mechanism."""
    folder = Path(mkdtemp()) / "generated"
    shutil.copytree(own.generated(name), folder, ignore=shutil.ignore_patterns("__pycache__"))
    for cache in (generated.module, generated.sidecar, formulas.load):
        cache.cache_clear()
    return folder


def call(name: str, folder: Path) -> tuple[str, ...]:
    command, *options = NAMES[name]
    return command, str(folder / f"{name}.toml"), *options


def rewrite(path: Path, old: str, new: str) -> None:
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))


CASES = {
    "no lane": lambda folder: rewrite(folder / "slider_crank.py", "def lane(", "def lost("),
    "no lane over arrays": lambda folder: rewrite(
        folder / "array" / "slider_crank.py", "def lane(", "def lost("
    ),
    "empty module": lambda folder: (folder / "slider_crank.py").write_text(""),
    "no module": lambda folder: (folder / "slider_crank.py").unlink(),
    "no module over arrays": lambda folder: (folder / "array" / "slider_crank.py").unlink(),
    "broken module": lambda folder: rewrite(folder / "slider_crank.py", "def lane(", "def ( lane("),
    "module that fails": lambda folder: rewrite(
        folder / "slider_crank.py",
        "def lane() -> Function:",
        "def lane() -> Function:\n    raise KeyError('phi')",
    ),
    "module that gives nothing": lambda folder: rewrite(
        folder / "slider_crank.py",
        "def lane() -> Function:",
        "def lane() -> Function:\n    return 1",
    ),
    "module that is not text": lambda folder: (folder / "slider_crank.py").write_bytes(
        b"\xff\xfe\x00\x01"
    ),
    "empty sidecar": lambda folder: (folder / "slider_crank.json").write_text(""),
    "sidecar of nothing": lambda folder: (folder / "slider_crank.json").write_text("{}"),
    "sidecar that is no object": lambda folder: (folder / "slider_crank.json").write_text("[]"),
    "no sidecar": lambda folder: (folder / "slider_crank.json").unlink(),
}


@pytest.mark.parametrize("case", CASES)
def test_spoiled_model_is_one_sentence(case: str) -> None:
    folder = copy("slider_crank")
    assert run(*call("slider_crank", folder))[0] == 0
    folder = copy("slider_crank")
    CASES[case](folder)
    assert "planter derive" in refusal(*call("slider_crank", folder))


def list_places(entry: Any, *path: str | int) -> list[tuple[str | int, ...]]:
    children = (
        entry.items()
        if isinstance(entry, dict)
        else enumerate(entry[:2])
        if isinstance(entry, list)
        else ()
    )
    return [path, *(place for key, value in children for place in list_places(value, *path, key))]


@seed(SEED)
@share
@given(
    name=st.sampled_from(sorted(NAMES)),
    at=st.floats(0, 1),
    content=st.sampled_from([None, "lost", [], {}, 3, "delete", {"name": 1}]),
)
def test_sidecars_with_other_parts_end_in_sentences(name: str, at: float, content: object) -> None:
    folder = copy(name)
    path = folder / f"{name}.json"
    sidecar = json.loads(path.read_text())
    places = [place for place in list_places(sidecar) if place]
    *parents, key = places[int(at * (len(places) - 1))]
    entry = sidecar
    for parent in parents:
        entry = entry[parent]
    if content == "delete":
        del entry[key]
    else:
        entry[key] = content
    path.write_text(json.dumps(sidecar))
    assert_ends_properly(*call(name, folder))


@seed(SEED)
@share
@given(name=st.sampled_from(sorted(NAMES)), at=st.floats(0, 1), is_array=st.booleans())
def test_modules_that_are_cut_end_in_sentences(name: str, at: float, is_array: bool) -> None:
    folder = copy(name)
    path = folder / ("array" if is_array else "") / f"{name}.py"
    text = path.read_text()
    path.write_text(text[: int(at * len(text))])
    assert_ends_properly(*call(name, folder))
