"""`planter doctor`: what it says is so, and it changes nothing."""

import os
import platform
import shutil
import tomllib
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import casadi as ca
import pytest

import planter
from planter.doctor import examination
from planter.doctor.examination import EXTRAS
from planter.kernels import backends, compiler, toolchain
from planter.planting.file import load
from planter.planting.functions import Model
from planter.planting.model import Device
from tests.support.cli import answer, run
from tests.support.lanes import needs_compiler, path_of


@cache
def _device(model: Model) -> Device:
    """Made once; what is foreseen of it is looked up anew at every examination."""
    return Device(load(examination.MACHINE), model)


def test_extras_are_those_of_users_in_pyproject() -> None:
    project = tomllib.loads(
        (Path(__file__).parents[3] / "pyproject.toml").read_text(encoding="utf-8")
    )["project"]
    of_developers = {"lab", "test", "bench", "docs", "dev"}
    assert EXTRAS.keys() == project["optional-dependencies"].keys() - of_developers
    listed = {extra["name"]: extra["installed"] for extra in answer("doctor")["extras"]}
    assert listed == {name: find_spec(module) is not None for name, (module, _) in EXTRAS.items()}


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("PLANTER_CACHE", str(tmp_path / "cache"))
    monkeypatch.delenv("PLANTER_KERNELS", raising=False)
    monkeypatch.setattr(examination, "Device", lambda machine, model: _device(model))
    return tmp_path / "cache"


def examined(*arguments: str) -> dict:  # type: ignore[type-arg]
    result: dict = answer("doctor", *arguments)  # type: ignore[type-arg]
    return result


def ways_of(result: dict) -> dict[str, tuple[str, bool]]:  # type: ignore[type-arg]
    return {
        k["name"]: (k["way"], k["compiled"]) for k in result["kernels"] if k["model"] == "exact"
    }


@needs_compiler
def test_doctor_reports_without_compiling(folder: Path) -> None:
    result = examined()
    assert result["versions"]["planter"] == planter.__version__
    assert result["versions"]["casadi"] == ca.CasadiMeta.version()
    assert result["versions"]["python"] == platform.python_version()
    assert result["compiler"]["path"] == toolchain.find_compiler().path
    assert result["compiler"]["vector_bits"] in (64, 128, 256, 512)
    assert result["cache"] == {
        "folder": str(folder),
        "exists": False,
        "files": 0,
        "bytes": 0,
        "damaged": 0,
        "problem": None,
    }
    assert not folder.exists()
    assert ways_of(result)["rows"] == ("lanes", False)
    assert ways_of(result)["prologue"] == ("casadi-c", False)
    assert [a["do"] for a in result["advice"]][-1].startswith("planter doctor --build")


@needs_compiler
def test_compiled_and_damaged_libraries_are_reported(folder: Path) -> None:
    kernel = Device(load("wang2017")).force.response.values_kernel
    kernel.compile()
    result = examined()
    assert ways_of(result)["rows"] == (kernel.way, True)
    assert ways_of(result)["slopes"] == ("lanes", False)
    (path,) = folder.iterdir()
    assert (result["cache"]["files"], result["cache"]["bytes"]) == (1, path.stat().st_size)
    shorter = path.read_bytes()[:-1]
    path.unlink()  # what this process has loaded stays whole
    path.write_bytes(shorter)
    result = examined()
    assert result["cache"]["damaged"] == 1
    assert ways_of(result)["rows"] == ("lanes", False)
    assert "damaged" in result["advice"][0]["missing"]


@needs_compiler
def test_refused_library_is_named(folder: Path) -> None:
    kernel = Device(load("wang2017")).force.response.values_kernel
    kernel.compile()
    (path,) = folder.iterdir()
    path.chmod(0o777)
    result = examined()
    assert result["advice"][0] == {
        "missing": f"{path} is not loaded: it may be written by others",
        "do": "remove it",
    }
    assert result["cache"]["damaged"] == 0
    assert ways_of(result)["rows"] == ("casadi-vm", False)
    assert ways_of(result)["slopes"] == ("lanes", False)
    path.unlink()
    path.symlink_to("nowhere")
    assert "is a link" in examined()["advice"][0]["missing"]


@needs_compiler
def test_a_compiler_of_several_words(monkeypatch: pytest.MonkeyPatch) -> None:
    plain = examined()["compiler"]
    monkeypatch.setenv("CC", "env cc")
    compiler = examined()["compiler"]
    assert compiler["path"] != plain["path"]
    assert (compiler["flags"], compiler["vector_bits"]) == (plain["flags"], plain["vector_bits"])


def test_silent_compiler_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    silent = tmp_path / "silent"
    silent.write_text("#!/bin/sh\nsleep 300\nexit\n")
    silent.chmod(0o755)
    monkeypatch.setenv("CC", str(silent))
    monkeypatch.setattr(compiler, "PROBE_TIMEOUT_S", 0.5)
    result = examined()
    assert result["compiler"] == {
        "problem": f"the C compiler {silent} does not answer within 0.5 s"
    }
    assert {way for way, _ in ways_of(result).values()} == {"casadi-vm"}


@needs_compiler
def test_build_option_builds(monkeypatch: pytest.MonkeyPatch) -> None:
    """With the functions that take seconds left out."""
    monkeypatch.setattr(examination, "Device", Device)
    quick = examination._used
    monkeypatch.setattr(examination, "_used", lambda device: quick(device)[3:4])
    monkeypatch.setattr(Device, "compile", lambda self, refined: None)
    monkeypatch.setattr("planter.planting.objective.CycleObjective", lambda device: None)
    result = examined("--build")
    assert [(k["way"], k["compiled"]) for k in result["kernels"]] == [("lanes", True)] * 2
    assert not any("not compiled yet" in a["missing"] for a in result["advice"])


def test_missing_compiler_has_advice(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", "no-such-compiler")
    result = examined()
    assert "planter[compiler]" in result["advice"][0]["do"]
    assert result["compiler"] == {"problem": "there is no C compiler 'no-such-compiler'"}
    assert {way for way, _ in ways_of(result).values()} == {"casadi-vm"}
    assert "install gcc" in result["advice"][0]["do"]


@needs_compiler
def test_bundled_compiler_is_used_with_slow_first_use(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    cc = path_of("gcc")
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.delenv(compiler.CACHE_VARIABLE, raising=False)
    monkeypatch.setenv("PATH", f"{os.environ['PATH']}{os.pathsep}{tmp_path}")
    monkeypatch.setattr(shutil, "which", lambda name: None)
    monkeypatch.setattr(compiler, "bundled_command", lambda: (cc, "-DSOME=1"))
    result = examined()
    assert (result["compiler"]["path"], result["compiler"]["bundled"]) == (cc, True)
    assert ways_of(result)["rows"] == ("lanes", False)
    assert any(f"about {compiler.preparation_time_s()} s" in a["missing"] for a in result["advice"])


@pytest.mark.parametrize("place", ["/dev/null/cache", "open"])
def test_unusable_folder_is_reported(
    place: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "open").mkdir()
    (tmp_path / "open").chmod(0o777)
    monkeypatch.setenv("PLANTER_CACHE", str(tmp_path / place))
    result = examined()
    assert result["cache"]["problem"] is not None
    assert {way for way, _ in ways_of(result).values()} == {"casadi-vm"}
    assert any("PLANTER_CACHE" in a["do"] for a in result["advice"])


@needs_compiler
def test_set_limit_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PLANTER_KERNELS", "casadi-c")
    result = examined()
    assert {way for way, _ in ways_of(result).values()} == {"casadi-c"}
    assert any("PLANTER_KERNELS" in a["missing"] for a in result["advice"])


def test_clang_is_recognised(monkeypatch: pytest.MonkeyPatch) -> None:
    if platform.machine() != "x86_64":
        pytest.skip("the vector library of x86-64")
    monkeypatch.setenv("CC", path_of("clang"))
    assert any("arc tangent" in a["missing"] for a in examined()["advice"])


@needs_compiler
def test_forecast_equals_outcome(kernel_cache: None, monkeypatch: pytest.MonkeyPatch) -> None:
    device = Device(load("wang2017"))
    for limit in backends.BACKENDS:
        monkeypatch.setenv("PLANTER_KERNELS", limit)
        for kernel in (device.force.response.values_kernel, device.force.response.hoisting_kernel):
            kernel.compile()
            assert kernel.way == backends.predict_backend(kernel.work)


def test_tables_for_people() -> None:
    code, out, _ = run("doctor")
    assert code == 0
    assert "This installation" in out
    assert "slopes" in out
