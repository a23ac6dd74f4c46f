"""One page for all tests of it: its functions are compiled once."""

from __future__ import annotations

import pytest

from tests.planter.studio.static.told import Told, written


@pytest.fixture(scope="session")
def page(tmp_path_factory: pytest.TempPathFactory) -> Told:
    return written(tmp_path_factory.mktemp("page"), "wang2017-wide")
