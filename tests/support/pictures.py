"""`python -m tests.support.pictures` renews the pictures of README.md: figures of commands, some
made smaller.
"""

from __future__ import annotations

import shutil
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from PIL import Image

from planter.report import files, style
from tests.support.cli import run
from tests.support.structure import ROOT

FOLDER = ROOT / "docs"
SMALL = "pictures/"
"""Folder of the pictures that are made smaller."""
PICTURES = {
    "support_force.png": ("simulate wang2017", "figures/support_force.png"),
    "pictures/motion.gif": ("animate wang2017 --seconds 2", ""),
    "pictures/symbols.png": ("explain wang2017", "figures/train.png"),
    "pictures/gears.png": ("gears wang2017 --teeth 31,31 --module1 2", "figures/assembly.png"),
    "pictures/pickup.png": ("pickup yu2023", "figures/path.png"),
    "pictures/clutch.png": ("clutch geometry shi2021", "figures/turning.png"),
    "pictures/linkage.png": ("synthesise sun2019-corrected", "figures/linkage_1_2.png"),
}
"""Pictures, each with its command and the file in its folder; without one, `--out` names the
picture itself.
"""
WIDTH, COLOURS = 480, 64


def draw_picture(name: str, folder: Path) -> Path:
    """Draw a picture into a folder and return its path.

    Raises RuntimeError if its command fails.
    """
    command, figure = PICTURES[name]
    picture = folder / Path(name).name
    out = picture.with_suffix("") if figure else picture
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(files, "style", style)  # which the tests replace by a quicker one
        code, _, message = run(command, "--out", str(out))
    if code != 0:
        raise RuntimeError(f"planter {command}: {message}")
    if figure:
        with Image.open(out / figure) as image:
            small = image.convert("RGB")
            if name.startswith(SMALL):
                small.thumbnail((WIDTH, WIDTH))
            small.quantize(COLOURS, Image.Quantize.MAXCOVERAGE).save(picture, optimize=True)
    return picture


if __name__ == "__main__":
    (FOLDER / SMALL).mkdir(exist_ok=True)
    with TemporaryDirectory() as scratch:
        for each in PICTURES:
            shutil.copyfile(draw_picture(each, Path(scratch)), FOLDER / each)
