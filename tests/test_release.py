"""What a release says of itself: versions agree, the sdist is whole, licences are listed, workflows
name targets.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from collections.abc import Iterable, Iterator
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import pytest
import yaml
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from packaging.version import Version

from planter import __version__
from tests.support import licences
from tests.support.structure import ROOT

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
MAKEFILE = (ROOT / "Makefile").read_text(encoding="utf-8")


def build(source: Path, kind: str, folder: Path) -> Path:
    """A wheel or an sdist of a source tree."""
    command = [sys.executable, "-m", "hatchling", "build", "-t", kind, "-d", str(folder)]
    subprocess.run(command, cwd=source, check=True, capture_output=True)
    return next(folder.glob("planter-*.whl" if kind == "wheel" else "planter-*.tar.gz"))


def content(wheel: Path) -> dict[str, bytes]:
    with zipfile.ZipFile(wheel) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def targets() -> set[str]:
    return set(re.findall(r"^([a-z-]+):", MAKEFILE, re.MULTILINE))


def list_actions(workflow: Path | str) -> Iterator[str]:
    """Make targets that the steps of a workflow ask for."""
    text = workflow.read_text(encoding="utf-8") if isinstance(workflow, Path) else workflow
    for job in yaml.safe_load(text)["jobs"].values():
        for step in job["steps"]:
            for line in step.get("run", "").splitlines():
                if line.startswith("make "):
                    yield line.split()[1]


def pins(name: str) -> dict[str, str]:
    lines = (ROOT / name).read_text(encoding="utf-8").splitlines()
    pins = (line.partition("==") for line in lines if line and not line.startswith("#"))
    return {canonicalize_name(package): pinned for package, _, pinned in pins}


def list_requirements(extras: Iterable[str]) -> Iterator[Requirement]:
    """What the package asks for by itself and with some extras."""
    yield from map(Requirement, PROJECT["dependencies"])
    for extra in extras:
        yield from map(Requirement, PROJECT["optional-dependencies"][extra])


def too_high(pinned: dict[str, str]) -> list[str]:
    """Packages that are pinned above the lower bound that they have in pyproject.toml."""
    packages = []
    for requirement in list_requirements(("derive", "notebook", "studio", "parquet")):
        bound = next(part.version for part in requirement.specifier if part.operator == ">=")
        have = pinned.get(canonicalize_name(requirement.name), "0")
        if Version(have) != Version(bound):
            packages.append(f"{requirement.name}: {have}, not {bound}")
    return packages


def test_the_version_is_the_same_everywhere() -> None:
    changes = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert (
        re.findall(r"^## \[([^]]+)\]", changes, re.MULTILINE)[0] == __version__ == cited["version"]
    )
    assert cited["license"] == PROJECT["license"]
    assert {"cff-version", "message", "title", "authors", "type"} <= cited.keys()


def test_every_file_has_a_licence_by_the_rules_of_reuse() -> None:
    annotations = tomllib.loads((ROOT / "REUSE.toml").read_text(encoding="utf-8"))["annotations"]
    first, *exceptions = annotations
    assert (first["path"], first["SPDX-License-Identifier"]) == ("**", PROJECT["license"])
    for annotation in exceptions:  # equations of texts under licences of their own
        assert (ROOT / "LICENSES" / f"{annotation['SPDX-License-Identifier']}.txt").is_file()
        paths = annotation["path"] if isinstance(annotation["path"], list) else [annotation["path"]]
        assert all(path.startswith("tests/papers/") and list(ROOT.glob(path)) for path in paths)
    assert (ROOT / "LICENSES" / "Apache-2.0.txt").read_bytes() == (ROOT / "LICENSE").read_bytes()


def test_size_of_the_installation_is_recorded() -> None:
    """Versions of packages differ by less than a fifth in their sizes."""
    recorded = json.loads(licences.SIZE.read_text(encoding="utf-8"))
    try:
        measured = licences.measure_installation()
    except PackageNotFoundError as missing:
        pytest.skip(f"{missing} is not installed")
    assert measured["size_GB"] == pytest.approx(recorded["size_GB"], rel=0.2)


def test_licences_of_all_dependencies_are_listed() -> None:
    rows = [
        line.split(" | ")
        for line in licences.PAGE.read_text(encoding="utf-8").splitlines()
        if " | " in line
    ]
    listed = {
        canonicalize_name(name.strip("| ")): (licence_text, licence)
        for name, licence_text, licence, *_ in rows[1:]
    }
    assert {
        canonicalize_name(requirement.name) for requirement in list_requirements(licences.EXTRAS)
    } <= listed.keys()
    assert not [name for name, (_, licence) in listed.items() if licence in ("", "not named")]
    for name in listed:
        try:
            licence_text = licences.row(name, "").split(" | ")[1:3]
        except PackageNotFoundError:
            continue
        if version(name) == listed[name][0]:
            assert tuple(licence_text) == listed[name]


def test_sdist_contains_all_wheel_sources(tmp_path: Path) -> None:
    folder = os.environ.get("PLANTER_DIST")
    sdist = next((ROOT / folder).glob("*.tar.gz")) if folder else build(ROOT, "sdist", tmp_path)
    with tarfile.open(sdist) as archive:
        archive.extractall(tmp_path / "source", filter="data")
    (source,) = (tmp_path / "source").iterdir()
    assert source.name == f"planter-{__version__}"
    assert {
        "README.md",
        "LICENSE",
        "Makefile",
        "tests",
        "docs",
        "CONTRIBUTING.md",
        "SECURITY.md",
    } <= {path.name for path in source.iterdir()}
    again, direct = (
        build(source, "wheel", tmp_path / "again"),
        build(ROOT, "wheel", tmp_path / "direct"),
    )
    assert content(again) == content(direct)


def test_workflows_cover_three_systems_and_existing_targets() -> None:
    assert WORKFLOWS
    systems = {
        system
        for path in WORKFLOWS
        for job in yaml.safe_load(path.read_text(encoding="utf-8"))["jobs"].values()
        for system in job.get("strategy", {}).get("matrix", {}).get("system", ())
    }
    assert {name.partition("-")[0] for name in systems} == {"ubuntu", "macos", "windows"}
    for path in WORKFLOWS:
        actions = set(list_actions(path))
        assert actions <= targets()
        assert actions
    assert {"test", "lint", "check-generated", "release"} <= {
        target for path in WORKFLOWS for target in list_actions(path)
    }


def test_missing_target_is_detected() -> None:
    assert set(
        list_actions("jobs: {one: {steps: [{run: make tset PYTHON=python}]}}")
    ) - targets() == {"tset"}


def test_oldest_versions_are_allowed_minimum() -> None:
    pinned = pins("constraints-oldest.txt")
    assert not too_high(pinned)
    assert too_high(pinned | {"typer": "0.99.0"}) == ["typer: 0.99.0, not 0.18"]


@pytest.mark.parametrize("name", ["constraints.txt", "constraints-oldest.txt"])
def test_pinned_versions_are_allowed(name: str) -> None:
    pinned = pins(name)
    for requirement in list_requirements(("derive", "notebook", "studio", "parquet")):
        assert requirement.specifier.contains(pinned[canonicalize_name(requirement.name)]), (
            requirement
        )
