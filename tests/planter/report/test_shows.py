"""Where else the drawing is seen: a notebook's widget, a GIF; and machines of every room to be
changed by hand.
"""

from __future__ import annotations

import io
import shutil
from pathlib import Path

import pytest
from PIL import Image

import planter
from planter import load_machine, simulate
from planter.errors import InputError
from planter.papers.planting.file import load
from planter.papers.planting.model import Device
from planter.report.animation import animate, gif, pack_scene, show_object
from planter.report.picture import draw_picture
from planter.report.subject import open_machine
from tests.support import own
from tests.support.cli import answer, run


@pytest.fixture(scope="module")
def device() -> Device:
    return Device(load("wang2017"))


def test_a_widget_holds_the_picture_and_the_record(device: Device) -> None:
    """What a notebook's page is sent is what a report's page holds."""
    from planter.papers.planting.report.scene import build_scene

    widget = simulate(device, 16).show()
    seen = build_scene(device, device.design)
    assert widget.picture == draw_picture(seen)
    assert widget.record == pack_scene(seen) == device.show().record
    with pytest.raises(InputError, match="nothing to show of a float"):
        show_object(1.0)
    state = widget.get_state()
    assert "class Drawing" in state["_esm"]
    assert set(state) >= {"picture", "record", "_css"}
    assert planter.show("wang2017").record == widget.record
    with pytest.raises(InputError, match="one of exact, printed"):
        planter.show("wang2017", model="own")


def test_mechanism_is_shown_as_the_device_is() -> None:
    source = str(own.generated("slider_crank") / "slider_crank.toml")
    widget = simulate(load_machine(source)).show()
    assert widget.record["moments"] > 300
    assert "<title>guide</title>" in widget.picture
    assert planter.show(source).record["chains"] == widget.record["chains"]
    assert "planet" in simulate(load_machine("wang2017"), 16).show().picture


def test_a_gif_moves_and_comes_back(device: Device) -> None:
    from planter.papers.planting.report.scene import build_scene

    image = Image.open(io.BytesIO(gif(build_scene(device, device.design), seconds=0.4)))
    assert image.n_frames == 8
    first = image.convert("RGB").tobytes()
    image.seek(4)
    assert image.convert("RGB").tobytes() != first
    assert image.info["loop"] == 0


def test_command_writes_gif_to_given_path(tmp_path: Path) -> None:
    words = ("animate", "shi2021", "--seconds", "0.2", "--out", str(tmp_path))
    result, file = answer(*words), tmp_path / "shi2021.gif"
    assert result == {
        "file": str(file),
        "machine": "shi2021",
        "model": "exact",
        "frames": 4,
        "seconds": 0.2,
        "bytes": file.stat().st_size,
    }
    assert file.read_bytes().startswith(b"GIF89a")
    _, printed, _ = run(*words)
    assert printed.startswith(f"{file}: shi2021, 4 frames in 0.2 s, ")
    with pytest.raises(InputError, match=r"ends in \.gif"):
        animate("shi2021", {}, tmp_path / "moving.avi")
    with pytest.raises(InputError, match="one of exact, printed"):
        animate("wang2017", {}, tmp_path, model="own")
    with pytest.raises(InputError, match="nobody: there is no built-in"):
        animate("nobody", {}, tmp_path)


def test_gif_has_requested_size_and_length(tmp_path: Path) -> None:
    """A long cycle has fewer frames, which last as long together, unless a rate is given."""
    for words, count in ((("--seconds", "20"), 200), (("--seconds", "0.5", "--rate", "50"), 25)):
        file = tmp_path / f"{count}.gif"
        answer("animate", "shi2021", *words, "--width", "121", "--out", str(file))
        image = Image.open(file)
        assert (image.width, image.n_frames) == (120, count)
        lengths = []
        for frame in range(count):
            image.seek(frame)
            lengths.append(image.info["duration"])
        assert sum(lengths) == pytest.approx(1e3 * float(words[1]), rel=0.01)


@pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="needs ffmpeg")
@pytest.mark.parametrize(("suffix", "marks"), [(".mp4", b"ftyp"), (".webm", b"webm")])
def test_videos_are_written_by_ffmpeg(suffix: str, marks: bytes, tmp_path: Path) -> None:
    files = [tmp_path / f"{name}{suffix}" for name in ("one", "two")]
    for file in files:
        answer("animate", "shi2021", "--seconds", "0.2", "--width", "120", "--out", str(file))
    assert marks in files[0].read_bytes()[:64]
    assert files[0].read_bytes() == files[1].read_bytes()


def test_video_without_ffmpeg_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(InputError, match="ffmpeg"):
        animate("shi2021", {}, tmp_path / "moving.mp4")
    assert not (tmp_path / "moving.mp4").exists()


def test_changed_device_equals_changed_file() -> None:
    """What is kept from the machine before changes nothing: speeds, masses and designs against a
    new device.
    """
    machine = open_machine("wang2017")
    values = {control.path: control.value for control in machine.controls}
    machine.readings(values, "exact")
    values |= {"operation.speed_rpm": 35.0, "mass.planet_kg": 1.1, "design.R3_mm": 30.9}
    device = Device(
        load("wang2017", {"operation.speed_rpm": 35.0, "mass.planet_kg": 1.1, "design.R3_mm": 30.9})
    )
    readings = {control.name: control.value for control in machine.readings(values, "exact")}
    result = simulate(device).result
    assert readings["range of the support force, 360 samples"] == pytest.approx(
        result.support_force.range_N, rel=1e-12
    )
    assert readings["objective (31), 360 samples"] == pytest.approx(result.objective, rel=1e-12)
    before = {
        control.name: control.value for control in open_machine("wang2017").readings({}, "exact")
    }
    assert readings["weight"] != pytest.approx(before["weight"])
