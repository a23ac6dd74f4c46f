"""`planter explain FILE` of a mechanism: everything that its statement says, and nothing that it does not."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.support import own
from tests.support.cli import answer, refusal


@pytest.fixture(scope="module")
def path() -> str:
    return str(own.generated("cam_follower") / "cam_follower.toml")


def test_values_quantities_and_functions_are_those_of_the_sidecar(path: str, tmp_path: Path) -> None:
    found = answer("explain", path, "--set", "h_mm=15", "--out", str(tmp_path))
    sidecar = own.file("cam_follower").model.sidecar
    assert [one["name"] for one in found["values"]] == [entry["name"] for entry in sidecar["vectors"]["data"]]
    assert [one["name"] for one in found["quantities"]] == [entry["name"] for entry in sidecar["vectors"]["outputs"]]
    assert [one["name"] for one in found["functions"]] == list(sidecar["functions"])
    lift = next(one for one in found["values"] if one["name"] == "h")
    assert lift["value"] == 15.0
    assert lift["allowed"] == "from 8 to 20 mm"
    push = next(one for one in found["quantities"] if one["name"] == "N_cam")
    assert "only push" in push["meaning"]
    assert {one["kind"] for one in found["quantities"]} == {"quantity", "check"}
    assert {file.name for file in tmp_path.iterdir()} >= set(found["files"])


@pytest.mark.parametrize(("key", "kind"), [("h_mm", "value"), ("values.h_mm", "value"), ("N_cam_N", "quantity")])
def test_a_key_has_its_meaning(path: str, key: str, kind: str) -> None:
    (meaning,) = answer("explain", path, key)["meanings"]
    assert meaning["kind"] == kind


def test_unknown_keys_are_refused_with_close_ones(path: str) -> None:
    assert "did you mean N_cam" in refusal("explain", path, "N_camm")
    assert "F_B1x" in refusal("explain", "wang2017", "F_B1xx")
    assert "there is no such machine" in refusal("explain", "nowhere.toml", "h_mm")
