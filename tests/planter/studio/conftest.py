"""A studio for the tests of a module."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.planter.studio.serving import studio


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("studio")


@pytest.fixture(scope="module")
def address(folder: Path) -> Iterator[str]:
    with studio(folder, "wang2017-wide") as address:
        yield address
