"""Forks beside busy threads: in the child only the forking thread goes on, and nobody opens the locks of the others.

`multiprocessing` forks by default on Linux up to Python 3.13. Locks of this package are waited for; the lock that
`functools.cached_property` holds before Python 3.12 while any object computes that property is made anew in the child.
"""

from __future__ import annotations

import gc
import os
import sys
import threading
from functools import cached_property
from typing import Any


def guard(lock: Any) -> None:
    """Let a fork wait for a reentrant lock, so that its child finds it open."""
    if hasattr(os, "register_at_fork"):
        os.register_at_fork(before=lock.acquire, after_in_parent=lock.release, after_in_child=lock.release)


def _renew() -> None:
    """Open the locks of all cached properties: what their holders computed in the parent is computed anew here."""
    for found in gc.get_objects():
        if type(found) is cached_property:
            vars(found)["lock"] = threading.RLock()


if sys.version_info < (3, 12) and hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_renew)
