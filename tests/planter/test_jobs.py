"""Jobs in worker processes: results in order, whatever becomes of the workers; errors as if raised
here.
"""

import pickle
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from planter import jobs
from planter.errors import ComputationError, InputError, PlanterError
from planter.jobs import Jobs, run_in_order
from planter.task import AUTO, Means, Task, run_job
from tests.planter.toys import ERRORS, prepare_squares

pytestmark = pytest.mark.fault
SQUARES = Task(prepare_squares, {})
EXPECTED = [number**2 / 3 for number in range(7)]


@pytest.fixture(scope="module")
def two_workers() -> Iterator[list[PlanterError]]:
    """Errors that workers sent: of the toys, and of a result and of jobs that no pickle can be made
    of.
    """
    with Jobs(SQUARES, [*ERRORS, "function", lambda: 3], Means(2)) as under_way:
        yield [answer.content for answer in sorted(under_way)]


def test_killed_worker_is_replaced_and_job_repeated(tmp_path: Path) -> None:
    killing = replace(SQUARES, arguments={"fatal": 3, "mark": str(tmp_path / "killed")})
    with Jobs(killing, range(7), Means(2)) as under_way:
        assert list(under_way.in_order()) == EXPECTED
        assert under_way.workers == 2
    assert (tmp_path / "killed").exists()


def test_job_killing_every_worker_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(jobs, "MAX_LOST_PROCESSES", 2)
    killing = replace(SQUARES, arguments={"fatal": 1})
    with (
        Jobs(killing, [1], Means(1)) as under_way,
        pytest.raises(ComputationError, match="2 worker processes ended"),
    ):
        next(under_way.in_order())


def test_errors_arrive_as_they_were_raised(two_workers: list[PlanterError]) -> None:
    for error, sent in zip(ERRORS.values(), two_workers, strict=False):
        if isinstance(error, PlanterError):
            assert (type(sent), sent.table(), vars(sent)) == (
                type(error),
                error.table(),
                vars(error),
            )
        else:
            assert isinstance(sent, ComputationError)
            assert sent.message == "ValueError: a bug"
    assert [type(sent) for sent in two_workers[-2:]] == [ComputationError] * 2
    assert "cannot run job" in two_workers[-1].message


def test_jobs_added_later_are_run_by_the_same_processes() -> None:
    with Jobs(SQUARES, means=Means(1)) as under_way:
        for rest in (EXPECTED[:3], EXPECTED[3:]):
            start = under_way.count
            under_way.add(range(start, start + len(rest)))
            assert list(under_way.in_order()) == rest


def test_first_error_in_order_is_raised() -> None:
    results = []
    task_jobs = [1, "geometry", "computation"]
    with Jobs(SQUARES, task_jobs, Means(1)) as under_way, pytest.raises(InputError, match="a cusp"):
        results.extend(under_way.in_order())
    assert not results[1:]


def test_another_version_is_refused() -> None:
    error = run_job(pickle.dumps(("0.0", b"")), 1)
    assert isinstance(error, InputError)
    assert "install 0.0" in error.message


def test_workers_start_only_if_they_pay(monkeypatch: pytest.MonkeyPatch) -> None:
    started = []

    class Started(Jobs):
        def __init__(self, task: Task, rest: range, means: Means) -> None:
            started.append(list(rest))
            super().__init__(task, rest, Means(1))

    monkeypatch.setattr(jobs, "Jobs", Started)
    monkeypatch.setattr(jobs, "count_cores", lambda: 2)
    job = prepare_squares()
    assert list(run_in_order(SQUARES, range(7), AUTO, job, float)) == EXPECTED
    assert not started
    monkeypatch.setattr(jobs, "MIN_PARALLEL_S", 1e-9)
    assert list(run_in_order(None, range(7), AUTO, job, float)) == EXPECTED
    assert not started
    assert list(run_in_order(SQUARES, range(7), AUTO, job, float)) == EXPECTED
    assert started == [[1, 2, 3, 4, 5, 6]]


def test_cluster_without_dask_or_scheduler_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(jobs, "CONNECT_TIMEOUT_S", 0.2)
    with pytest.raises(InputError, match="must be the address of a Dask scheduler"):
        Jobs(SQUARES, [1], Means(cluster="tcp://127.0.0.1:1"))
    monkeypatch.setitem(__import__("sys").modules, "distributed", None)
    with pytest.raises(InputError, match=r"pip install 'planter\[cluster\]'"):
        Jobs(SQUARES, [1], Means(cluster="tcp://127.0.0.1:1"))
