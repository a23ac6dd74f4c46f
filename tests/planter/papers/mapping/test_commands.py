"""`planter synthesise` and `planter train`: keys of the contract, files, exit codes, one sentence
for bad input.
"""

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from planter.files import examples
from planter.papers.mapping.file import load_poses
from tests.planter.papers.mapping.data import CORRECTED
from tests.support.cli import answer, refusal, run
from tests.support.tables import read_cycle_csv


def poses_file(path: Path, rows: list, more: str = "") -> str:
    text = "".join(
        f"[[pose]]\nx_mm = {x!r}\ny_mm = {y!r}\nphi_deg = {phi!r}\n" for x, y, phi in rows
    )
    path.write_text(more + text, encoding="utf-8")
    return str(path)


def curve_file(path: Path, rows: list, header: str = "carrier_deg,relative_deg") -> str:
    path.write_text(
        "# a comment\n" + header + "\n" + "".join(f"{a},{b}\n" for a, b in rows), encoding="utf-8"
    )
    return str(path)


@cache
def corrected() -> dict:
    """The answer to the corrected poses."""
    return answer("synthesise", "sun2019-corrected")


def test_corrected_poses_have_a_linkage_with_a_circuit_defect() -> None:
    result = corrected()
    assert result["complex_pairs"] == 1
    assert [d["radius_mm"] for d in result["dyads"]] == pytest.approx([99.724, 202.0462], abs=1e-4)
    (linkage,) = result["linkages"]
    assert linkage["defects"] == {"order": False, "branch": False, "circuit": True}
    assert linkage["dyads"] == [1, 2]
    assert linkage["arm_length_mm"] == pytest.approx(211.5459, abs=5e-5)
    assert all(p["position_error_mm"] < 1e-10 for p in linkage["poses"])
    assert [p["assembly"] for p in linkage["poses"]] == [1, 1, 1, -1, -1]
    (reversal,) = result["monotone"]["reversals"]
    assert result["monotone"]["possible"] is False
    assert {reversal["from_pose"], reversal["to_pose"]} == {3, 4}
    assert reversal["deg"] == pytest.approx(31.2514291, abs=1e-6)


def test_built_in_poses_are_printed_and_corrected() -> None:
    printed, corrected = load_poses("sun2019"), load_poses("sun2019-corrected")
    assert printed.poses[0, 2] == -corrected.poses[0, 2]
    assert np.array_equal(printed.poses[1:], corrected.poses[1:])
    assert [(p.x_mm, p.y_mm, p.phi_deg) for p in corrected.pose] == CORRECTED
    assert corrected.origin("pose[0].phi_deg").startswith("calibrated")
    assert corrected.origin("pose[1].phi_deg") == "paper"


def test_carrier_may_be_another_dyad() -> None:
    result = answer("synthesise", "sun2019-corrected", "--carrier", "2")
    assert result["carrier_dyad"] == 2
    assert result["monotone"]["reversals"][0]["deg"] == pytest.approx(7.84544, abs=1e-5)
    assert "--carrier 3" in refusal("synthesise", "sun2019-corrected", "--carrier", "3")


@pytest.mark.parametrize(
    ("rows", "free", "note"),
    [
        (CORRECTED[:4], 1, "4 poses leave"),
        (CORRECTED[:2], 3, "2 poses leave"),
        ([*CORRECTED[:4], CORRECTED[0]], 1, "only 4 of the 5"),
        ([(x, y, 0) for x, y, _ in CORRECTED], 1, "depend on each other"),
    ],
)
def test_families_are_said(tmp_path: Path, rows: list, free: int, note: str) -> None:
    result = answer("synthesise", poses_file(tmp_path / "p.toml", rows))
    assert result["family"]["parameters"] == free
    assert (result["dyads"], result["linkages"], result["monotone"]) == ([], [], None)
    assert any(note in warning for warning in result["warnings"])


def test_no_real_dyads_is_an_answer(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    for _ in range(40):
        rows = [
            (*map(float, rng.uniform(-300, 300, 2)), float(rng.uniform(-115, 115)))
            for _ in range(5)
        ]
        result = answer("synthesise", poses_file(tmp_path / "p.toml", rows))
        if not result["dyads"]:
            break
    assert (result["complex_pairs"], result["linkages"], result["monotone"], result["nearest"]) == (
        2,
        [],
        None,
        None,
    )


def test_built_in_curve_has_a_train() -> None:
    result = answer("train", "sun2019-curve", "--crank-mm", "99.724")
    assert result["x_s"] == pytest.approx(0.969, abs=5e-5)
    assert result["ratio_max"] == pytest.approx(1 / result["slope_min"])
    assert result["carrier_bend_deg"] == pytest.approx(2 * np.degrees(np.arcsin(99.724 / 140)))
    assert max(map(abs, result["closure_error_rad"])) < 1e-10
    for smallest, largest in zip(result["radius_min_mm"], result["radius_max_mm"], strict=True):
        assert 0 < smallest < largest < 70
    assert answer("train", "sun2019-curve")["carrier_bend_deg"] is None


@pytest.mark.usefixtures("blank_figures")
def test_closest_curve_suits_the_train(tmp_path: Path) -> None:
    code, _, err = run("synthesise", "sun2019-corrected", "--out", str(tmp_path))
    assert code == 0, err
    result = json.loads((tmp_path / "summary.json").read_text())
    assert result["input"]["pose"][0]["phi_deg"] == -10
    assert result["provenance"]["machine_sha256"]
    names = {"dyads", "linkage_1_2", "angle_curve"}
    for suffix in (".svg", ".png"):
        assert {p.stem for p in (tmp_path / "figures").glob(f"*{suffix}")} == names
    _, columns = read_cycle_csv(tmp_path / "coupler_1_2_circuit2.csv")
    assert np.hypot(columns["tip_x_mm"] - 80, columns["tip_y_mm"] + 270).min() < 2
    assert "poses 4 and 3" in (tmp_path / "report.html").read_text(encoding="utf-8")
    train = answer("train", str(tmp_path / "nearest_curve.csv"), "--poses", "sun2019-corrected")
    assert train["slope_min"] == pytest.approx(0.1, abs=1e-6)
    for met, promised in zip(train["poses"], result["nearest"]["poses"], strict=True):
        assert met["position_error_mm"] ** 2 + met["hinge_error_mm"] ** 2 <= (
            promised["position_error_mm"] ** 2 + promised["hinge_error_mm"] ** 2 + 1e-9
        )


GOOD = "[[pose]]\nx_mm = 1\ny_mm = 1\nphi_deg = 1\n"
BAD_POSES = {
    "one pose": (GOOD, "pose"),
    "no poses": ("name = 'nothing'\n", "pose is missing"),
    "far": (
        GOOD.replace("x_mm = 1", "x_mm = 1e14")
        + GOOD.replace("x_mm = 1", "x_mm = 1.0000000000000002e14"),
        "nearer to the origin",
    ),
    "same": (GOOD + GOOD.replace("phi_deg = 1", "phi_deg = 361"), "one and the same"),
}


@pytest.mark.parametrize("kind", BAD_POSES)
def test_bad_poses_are_refused(tmp_path: Path, kind: str) -> None:
    text, message = BAD_POSES[kind]
    path = tmp_path / "bad.toml"
    path.write_text(text, encoding="utf-8")
    assert message in refusal("synthesise", str(path))


@pytest.mark.parametrize(
    "points", ["second_pose = 9", "second_pose = 4\nlinkage = 7", "second_pose = 0"]
)
def test_bad_choices_of_points_are_refused(tmp_path: Path, points: str) -> None:
    more = (
        f"[points]\nfirst_pose = 1\nfirst_carrier_deg = [0, 20, 40]\nsecond_carrier_deg = "
        f"[240]\n{points}\n"
    )
    assert "points." in refusal("synthesise", poses_file(tmp_path / "p.toml", CORRECTED, more))


TURN = [(0, 0), (100, -90), (220, -200), (360, -360)]
BAD_CURVES = {
    "header": (TURN, "carrier,relative", "header"),
    "open carrier": ([*TURN[:-1], (350, -360)], None, "carrier_deg = 350"),
    "open arm": ([*TURN[:-1], (360, -350)], None, "relative_deg = -350"),
    "backwards": (
        [(0, 0), (220, -90), (100, -200), (360, -360)],
        None,
        "line 5: carrier_deg = 100",
    ),
    "few": ([TURN[0], TURN[-1]], None, "at least 4"),
    "gap": (
        [(t, -t) for t in range(0, 361, 15) if not 98 < t < 260],
        None,
        "line 10: carrier_deg = 270",
    ),
}


@pytest.mark.parametrize("kind", BAD_CURVES)
def test_bad_curves_are_refused(tmp_path: Path, kind: str) -> None:
    rows, header, message = BAD_CURVES[kind]
    path = curve_file(tmp_path / "bad.csv", rows, header or "carrier_deg,relative_deg")
    assert message in refusal("train", path)


@pytest.mark.parametrize(
    "options",
    [
        ("--centre-distance-mm", "0"),
        ("--centre-distance-mm", "nan"),
        ("--crank-mm", "-3"),
        ("--crank-mm", "141"),
    ],
)
def test_bad_lengths_are_refused(options: tuple[str, str]) -> None:
    assert options[0] in refusal("train", "sun2019-curve", *options)


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ([(0, 0), (2, -2), (4, -4.5), (6.2832, -6.2832)], "are these radians?"),
        ([(0, 10), (100, 40), (200, -30), (360, 10)], "is this the arm's own angle?"),
        ([(0, 0), (100, -90), (200, -200), (350, -350)], "it must be 360, a turn after the first"),
    ],
)
def test_curves_of_other_kinds_are_suspected(rows: list, message: str, tmp_path: Path) -> None:
    assert message in refusal("train", curve_file(tmp_path / "other.csv", rows))


def test_wrong_kind_of_file_is_explained(tmp_path: Path) -> None:
    path = curve_file(tmp_path / "curve.csv", TURN)
    assert "poses are read from a TOML file" in refusal("synthesise", path)
    assert "poses are read from a TOML file" in refusal("train", "sun2019-curve", "--poses", path)
    (tmp_path / "poses.toml").write_text(examples.example("sun2019"))
    assert "this is a .toml file, but it must be a .csv file" in refusal(
        "train", str(tmp_path / "poses.toml")
    )


def test_reversing_curve_is_not_a_success(tmp_path: Path) -> None:
    path = curve_file(
        tmp_path / "back.csv", [(0, 0), (100, -90), (200, -60), (300, -250), (360, -360)]
    )
    code, out, err = run("train", path, "--json")
    assert code == 1
    assert "carrier angle" in err
    assert json.loads(out)["error"]["name"] == "ComputationError"
    assert json.loads(out)["partial"] is None
