"""`planter export motion`: the numbers of `simulate` over time."""

from pathlib import Path

import pytest

from planter.exports.motion_tables import FORMATS
from tests.support.cli import answer, refusal


@pytest.mark.parametrize("form", FORMATS)
def test_every_format_is_written(form: str, tmp_path: Path) -> None:
    result = answer(
        "export", "motion", "wang2017", "--format", form, "--samples", "8", "--out", str(tmp_path)
    )
    assert result["format"] == form
    assert {Path(file).name for file in result["files"]} == {
        path.name for path in tmp_path.iterdir() if path.name[0] != "."
    }


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--turns", "0"), "between 1 and 555 with 360 samples"),
        (("--turns", "99999"), "--turns = 99999"),
        (("--samples", "4"), "between 8 and"),
    ],
)
def test_invalid_request_is_refused(
    arguments: tuple[str, ...], message: str, tmp_path: Path
) -> None:
    assert message in refusal("export", "motion", "wang2017", *arguments, "--out", str(tmp_path))
