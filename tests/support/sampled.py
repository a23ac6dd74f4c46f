"""Cases of which the suite runs a sample; `-m long` runs the others."""

from collections.abc import Iterable
from typing import Any

import pytest


def sampled(always: Iterable[Any], all_items: Iterable[Any]) -> list[Any]:
    """Parameters of a test: those that are kept, then the others as `long`; a tuple is a value for
    each name.
    """
    chosen, remaining = list(always), list(all_items)
    for case in chosen:
        remaining.remove(case)
    return [*chosen, *(pytest.param(*_values(case), marks=pytest.mark.long) for case in remaining)]


def _values(case: Any) -> tuple[Any, ...]:
    return case if isinstance(case, tuple) else (case,)
