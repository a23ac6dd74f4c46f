"""Tests of the ways to evaluate: all of them are allowed."""

from collections.abc import Iterator

import pytest


@pytest.fixture(scope="module", autouse=True)
def _every_way() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.delenv("PLANTER_KERNELS", raising=False)
        yield
