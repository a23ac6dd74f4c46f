"""`python -m tests.support.pictures` renews the pictures of README.md: figures of commands, made smaller."""

from __future__ import annotations

import shutil
from pathlib import Path
from tempfile import TemporaryDirectory

from PIL import Image

from tests.support.cli import run
from tests.support.structure import ROOT

FOLDER = ROOT / "docs" / "pictures"
PICTURES = {
    "motion.gif": ("animate wang2017 --seconds 2", ""),
    "symbols.png": ("explain wang2017", "figures/train.png"),
    "gears.png": ("gears wang2017 --teeth 31,31 --module1 2", "figures/assembly.png"),
    "pickup.png": ("pickup yu2023", "figures/path.png"),
    "clutch.png": ("clutch geometry shi2021", "figures/turning.png"),
    "linkage.png": ("synthesise sun2019-corrected", "figures/linkage_1_2.png"),
}
"""Pictures, each with its command and the file in its folder; without one, `--out` names the picture itself."""
WIDTH, COLOURS = 480, 64


def draw_picture(name: str, folder: Path) -> Path:
    """Draw a picture into a folder and return its path. Raises RuntimeError if its command fails."""
    command, figure = PICTURES[name]
    picture, out = folder / name, folder / (Path(name).stem if figure else name)
    code, _, message = run(*command.split(), "--out", str(out))
    if code != 0:
        raise RuntimeError(f"planter {command}: {message}")
    if figure:
        with Image.open(out / figure) as image:
            small = image.convert("RGB")
            small.thumbnail((WIDTH, WIDTH))
            small.quantize(COLOURS).save(picture, optimize=True)
    return picture


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    with TemporaryDirectory() as scratch:
        for each in PICTURES:
            shutil.copyfile(draw_picture(each, Path(scratch)), FOLDER / each)
