"""Chunks of a job: found here or by processes; kept whole, found once."""

import json
import sqlite3
from pathlib import Path

import numpy as np
import pytest

from planter.errors import ComputationError, InputError, Interrupted
from planter.progress import Progress
from planter.rows import job
from planter.rows.job import CHUNK, Recipe, Store
from planter.task import AUTO, Means

ROWS = 3 * CHUNK + 7


def squares(**more: object) -> Recipe:
    return Recipe("tests.planter.rows.toys:Squares", {"rows": ROWS, **more})


def answered(
    recipe: Recipe, path: Path | None = None, means: Means = AUTO
) -> tuple[str, job.JobRun]:
    """Hash of the answer, and how it came about; the numbers are those of the job."""
    with Store(path, recipe.question, ROWS, 2) as store:
        done = job.run_job(recipe, store, means)
        rows = np.vstack(list(store.blocks()))
        assert np.array_equal(
            rows, np.column_stack([np.arange(ROWS), np.arange(ROWS, dtype=float) ** 2])
        )
        return store.digest(), done


def test_rows_are_equal_for_any_workers(monkeypatch: pytest.MonkeyPatch) -> None:
    alone, by_two, by_three = (answered(squares(), means=Means(count)) for count in (1, 2, 3))
    monkeypatch.setattr(job, "FEWEST", ROWS + 1)
    serial = answered(squares())
    assert [result[1].workers for result in (alone, by_two, by_three, serial)] == [1, 2, 3, 0]
    assert alone[0] == by_two[0] == by_three[0] == serial[0]


def test_job_error_is_reported() -> None:
    with pytest.raises(ComputationError, match="row 3 has no square"):
        answered(squares(wrong=CHUNK), means=Means(1))


def test_finished_chunks_are_reused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first, _ = answered(squares(), tmp_path / "kept.sqlite", Means(1))
    monkeypatch.setattr(job, "Jobs", pytest.fail)
    again, done = answered(squares(), tmp_path / "kept.sqlite")
    assert (again, done.resumed, done.workers) == (first, 4, 0)


def test_store_of_other_recipe_is_rejected(tmp_path: Path) -> None:
    path = tmp_path / "kept.sqlite"
    first, _ = answered(squares(), path, Means(1))
    with pytest.raises(InputError, match=path.name):
        Store(path, squares(wrong=-2).question, ROWS, 2)
    assert answered(squares(), path)[0] == first


def test_recipe_replaced_during_run_is_rejected(tmp_path: Path) -> None:
    path = tmp_path / "kept.sqlite"
    with Store(path, "q", ROWS, 2) as store:
        with sqlite3.connect(path) as file:
            file.execute("UPDATE asked SET question = 'other'")
        with pytest.raises(InputError, match=path.name):
            store.save(3, bytes(7 * 16))


TAMPERED = {
    "extra": "INSERT INTO chunks SELECT 4, sha256, content FROM chunks WHERE number = 3",
    "negative": ("INSERT INTO chunks SELECT -1, sha256, content FROM chunks WHERE number = 0"),
    "moved": "UPDATE chunks SET number = -1 WHERE number = 1",
    "short": "UPDATE chunks SET content = substr(content, 1, 16) WHERE number = 0",
    "no bytes": "UPDATE chunks SET content = 'text' WHERE number = 0",
    "another hash": "UPDATE chunks SET sha256 = 'two' WHERE number = 2",
    "zeros": "UPDATE chunks SET content = zeroblob(length(content)) WHERE number = 2",
    "missing": "DELETE FROM chunks WHERE number = 1",
}
SWAPPED = (
    "UPDATE chunks SET number = -1 WHERE number = 0",
    "UPDATE chunks SET number = 0 WHERE number = 1",
    "UPDATE chunks SET number = 1 WHERE number = -1",
)


@pytest.mark.parametrize(
    "statements",
    [*((statement,) for statement in TAMPERED.values()), SWAPPED],
    ids=[*TAMPERED, "swapped"],
)
def test_tampered_store_is_rejected(tmp_path: Path, statements: tuple[str, ...]) -> None:
    path, recipe = tmp_path / "kept.sqlite", squares()
    first, _ = answered(recipe, path, Means(1))
    with sqlite3.connect(path) as file:
        for statement in statements:
            file.execute(statement)
    with Store(path, recipe.question, ROWS, 2) as store:
        for read in (store.digest, lambda: list(store.blocks())):
            with pytest.raises(ComputationError, match=path.name):
                read()
    assert answered(recipe, path, Means(1))[0] == first


@pytest.mark.parametrize("is_database", [True, False])
def test_file_of_other_program_is_rejected(tmp_path: Path, is_database: bool) -> None:
    path = tmp_path / "kept.sqlite"
    if is_database:
        with sqlite3.connect(path) as file:
            file.execute("CREATE TABLE notes (text)")
    else:
        path.write_text("no database " * 100)
    content = path.read_bytes()
    with pytest.raises(InputError, match=path.name):
        Store(path, "q", ROWS, 2)
    assert path.read_bytes() == content


def test_interrupt_keeps_finished_chunks(tmp_path: Path) -> None:
    path, recipe = tmp_path / "kept.sqlite", squares()

    def stop(step: Progress) -> None:
        if step.done >= CHUNK:
            raise KeyboardInterrupt

    with Store(path, recipe.question, ROWS, 2) as store, pytest.raises(Interrupted) as stopped:
        job.run_job(recipe, store, Means(1), stop)
    assert stopped.value.partial == {"rows": ROWS, "rows_done": CHUNK}
    assert answered(recipe, path, Means(1))[1].resumed == 1


def test_recipe_order_is_preserved() -> None:
    """Inputs are columns: what a worker reads must have them in the order in which they were
    asked.
    """
    recipe = Recipe("a:b", {"speed": 1, "mass": 2})
    assert list(json.loads(recipe.text)["arguments"]) == ["speed", "mass"]
    assert recipe.question != Recipe("a:b", {"mass": 2, "speed": 1}).question
