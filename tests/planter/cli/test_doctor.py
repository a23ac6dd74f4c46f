"""`planter doctor`: what it says is so, and it changes nothing."""

import platform
import tomllib
from importlib.util import find_spec
from pathlib import Path

import casadi as ca
import pytest

import planter
from planter.cli.installation import EXTRAS
from planter.kernels import backends, toolchain
from tests.support.cli import answer, run
from tests.support.lanes import needs_compiler


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("PLANTER_CACHE", str(tmp_path / "cache"))
    monkeypatch.delenv("PLANTER_KERNELS", raising=False)
    return tmp_path / "cache"


def test_extras_are_those_of_users_in_pyproject() -> None:
    text = (Path(__file__).parents[3] / "pyproject.toml").read_text(encoding="utf-8")
    extras = tomllib.loads(text)["project"]["optional-dependencies"]
    assert EXTRAS.keys() == extras.keys() - {"lab", "test", "bench", "docs", "dev"}
    installed = {name: find_spec(module) is not None for name, module in EXTRAS.items()}
    assert answer("doctor")["extras"] == installed


@needs_compiler
def test_doctor_reports_without_compiling(folder: Path) -> None:
    result = answer("doctor")
    assert result["versions"] | {"numpy": ""} == {
        "planter": planter.__version__,
        "python": platform.python_version(),
        "casadi": ca.CasadiMeta.version(),
        "numpy": "",
    }
    assert result["compiler"] == toolchain.find_compiler().version
    assert result["cache"] == str(folder.resolve())
    assert not list(folder.iterdir())
    kernels = {kernel["name"]: kernel["way"] for kernel in result["kernels"]}
    assert kernels == {"tangent": "casadi-c", "rows": "lanes", "slopes": "lanes"}
    assert not any(kernel["compiled"] for kernel in result["kernels"])
    assert any("--build" in remedy for remedy in result["advice"].values())


@needs_compiler
def test_build_option_builds(folder: Path) -> None:
    result = answer("doctor", "--build")
    assert all(kernel["compiled"] for kernel in result["kernels"])
    assert not result["advice"]


def test_missing_compiler_has_advice(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", "no-such-compiler")
    result = answer("doctor")
    assert result["compiler"] is None
    assert "planter[compiler]" in result["advice"]["there is no C compiler 'no-such-compiler'"]
    assert {kernel["way"] for kernel in result["kernels"]} == {backends.BACKENDS[-1]}


@needs_compiler
def test_unusable_folder_is_reported(folder: Path) -> None:
    folder.mkdir()
    folder.chmod(0o777)
    result = answer("doctor")
    assert result["cache"] is None
    assert any("PLANTER_CACHE" in remedy for remedy in result["advice"].values())


@needs_compiler
def test_set_limit_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PLANTER_KERNELS", "casadi-c")
    result = answer("doctor")
    assert {kernel["way"] for kernel in result["kernels"]} == {"casadi-c"}
    assert result["advice"]["PLANTER_KERNELS allows nothing faster than casadi-c"] == "unset it"


def test_tables_for_people() -> None:
    code, out, _ = run("doctor")
    assert code == 0
    assert "This installation" in out
