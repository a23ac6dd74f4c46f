"""How the tests evaluate: by CasADi's virtual machine, alike on every machine, unless they ask for
compiled functions.

That all ways give the same is tested by itself, in `planter/kernels` and `planter/papers/planting`.
"""

import gc
import os
import sys
from collections.abc import Iterator
from types import SimpleNamespace

import pytest

from planter.report import files, style

# Without bytecode every process that a test starts would compile all sources anew: more than a
# second each.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False


def pytest_collection_finish() -> None:
    """Exempt imported objects, which last as long as the process, from garbage collection, and
    collect less often.

    SymPy allocates so many small objects that the default threshold costs 8 % of the derivations'
    time.
    """
    gc.collect()
    gc.freeze()
    gc.set_threshold(50_000, 20, 100)


@pytest.fixture(scope="session", autouse=True)
def _virtual_machine() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PLANTER_KERNELS", "casadi-vm")
        yield


@pytest.fixture(scope="session", autouse=True)
def _drawn_once() -> Iterator[None]:
    """Commands draw each figure as SVG alone, a third of the time; what PNG and PDF hold is tested
    with `planter.report.style`.
    """
    blank = SimpleNamespace(
        render_figure=lambda figure: {
            "svg": style.render_svg(figure),
            "png": b"\x89PNG".ljust(20_000),
            "pdf": b"%PDF".ljust(20_000),
        }
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(files, "style", blank)
        yield


@pytest.fixture(scope="module")
def kernel_cache(request: pytest.FixtureRequest) -> Iterator[None]:
    """Functions are compiled, and kept between runs, apart from the user's own."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PLANTER_CACHE", str(request.config.cache.mkdir("kernels")))
        patch.delenv("PLANTER_KERNELS", raising=False)
        yield


@pytest.fixture
def blank_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures are built, but empty sheets are written: drawing them takes most of the time, and is
    tested elsewhere.
    """
    sheets = {"svg": b"<svg></svg>", "png": b"", "pdf": b""}
    monkeypatch.setattr(style, "_rendered", lambda figure, kind, metadata: sheets[kind])
