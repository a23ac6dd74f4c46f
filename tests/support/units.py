"""Units (FMI) in tests: their libraries are for this system alone, compiled without passes."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from planter.exports import fmi


@contextmanager
def quick_libraries() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(fmi, "PLATFORMS", {"linux64": fmi.PLATFORMS["linux64"]})
        patch.setattr(fmi, "FLAGS", ("-O0", *fmi.FLAGS[1:]))
        yield
