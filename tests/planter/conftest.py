"""Compiled functions of the tests are kept between runs, apart from the user's own."""

from collections.abc import Iterator

import pytest


@pytest.fixture(scope="session")
def kernel_cache(request: pytest.FixtureRequest) -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PLANTER_CACHE", str(request.config.cache.mkdir("kernels")))
        patch.delenv("PLANTER_KERNELS", raising=False)
        yield
