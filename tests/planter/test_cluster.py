"""Jobs on a Dask cluster of two worker processes: the bytes are those of this process, though a
worker is killed.
"""

from collections.abc import Iterator
from pathlib import Path

import pytest
from distributed import LocalCluster

from planter.engine.solvers.local_search import search_from_starts
from planter.errors import GeometryError
from planter.jobs import Jobs
from planter.papers.planting.optimisation import build_descent_task
from planter.rows.job import CHUNK, Recipe, Store, run_job
from planter.task import Means
from tests.planter.engine.solvers import toys
from tests.planter.test_jobs import SQUARES

SAMPLES, STARTS, ROWS = 36, 2, 3 * CHUNK + 7


@pytest.fixture(scope="module")
def means() -> Iterator[Means]:
    with LocalCluster(
        n_workers=2, threads_per_worker=1, dashboard_address=None, silence_logs=50
    ) as dask:
        yield Means(cluster=dask.scheduler_address)


@pytest.mark.fault
def test_rows_survive_a_killed_worker(means: Means, tmp_path: Path) -> None:
    mark, digests = tmp_path / "killed", []
    for more in ({"fatal": CHUNK, "mark": str(mark)}, {}):
        recipe = Recipe("tests.planter.rows.toys:Squares", {"rows": ROWS, **more})
        with Store(None, recipe.question, ROWS, 2) as store:
            done = run_job(recipe, store, means if more else Means(1))
            digests.append(store.digest())
            assert done.workers == (2 if more else 1)
    assert mark.exists()
    assert digests[0] == digests[1]


def test_errors_arrive_as_they_were_raised(means: Means) -> None:
    with (
        Jobs(SQUARES, ["geometry"], means) as under_way,
        pytest.raises(GeometryError, match="a cusp at 3 deg"),
    ):
        list(under_way.in_order())


def test_descents_are_those_of_this_process(means: Means) -> None:
    local, remote = toys.problem(SAMPLES), toys.problem(SAMPLES)
    expected = list(search_from_starts(local, STARTS, 1))
    minima = list(
        search_from_starts(
            remote, STARTS, 1, task=build_descent_task(toys.device(), SAMPLES), means=means
        )
    )
    assert [m.u.tobytes() for m in minima] == [m.u.tobytes() for m in expected]
    assert [m.evaluation.objective for m in minima] == [m.evaluation.objective for m in expected]
    assert (remote.history, remote.counts) == (local.history, local.counts)
