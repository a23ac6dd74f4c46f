"""What `planter turn` and `planter move` write."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from planter.files import units
from planter.mechanism.file import MechanismFile
from planter.mechanism.motion import Motion
from planter.mechanism.report import page
from planter.mechanism.report.figures import Course
from planter.mechanism.turn import Turn
from planter.progress import Listener
from planter.report.html import Keys, Section, Table
from planter.report.labels import label


def write_turn(out: Path, found: Turn, machine: MechanismFile, progress: Listener | None = None) -> None:
    """A turn: every quantity, works, laws. Raises InputError for a folder that it cannot write."""
    course = Course(found.angles_deg, f"{found.angle} / deg", turn=True)
    title = f"A turn of {found.machine}"
    page.write(out, title, machine, found.table(), _turn(found), found.columns, course, progress)


def write_motion(out: Path, found: Motion, machine: MechanismFile, progress: Listener | None = None) -> None:
    """A free motion: every quantity, energy, the state of rest. Raises InputError as `write_turn`."""
    course = Course(found.times, "time / s", turn=False)
    title = f"Motion of {found.machine}"
    page.write(out, title, machine, found.table(), _motion(found), found.columns, course, progress)


def _turn(found: Turn) -> Iterator[Section]:
    rows = [
        (key, found.meanings[key], q.unit, q.min, q.min_deg, q.max, q.max_deg, q.mean, q.rms)
        for key, q in found.quantities.items()
    ]
    head = ("quantity", "meaning", "unit", "min", "at / deg", "max", "at / deg", "mean", "rms")
    yield Section("Turn", [Table(head, rows)])
    if found.work:
        yield Section("Work of a turn", [Keys({label(key): value for key, value in found.work.items()})])
    laws = [(law.law, law.violation, law.unit) for law in found.laws]
    yield Section("Laws", [Table(("law", "largest violation", "unit"), laws)])


def _motion(found: Motion) -> Iterator[Section]:
    rows = [
        (key, found.meanings[key], units.unit(key), float(v.min()), float(v.max()), float(v[-1]))
        for key, v in found.columns.items()
    ]
    yield Section("Motion", [Table(("quantity", "meaning", "unit", "min", "max", "last"), rows)])
    yield Section("Energy", [Keys({label(key): value for key, value in found.energy_J.items()})])
    if found.equilibrium is not None and found.eigenvalues is not None:
        rest = Keys({label(key): value for key, value in found.equilibrium.items()})
        yield Section("State of rest", [rest, Table(("real / 1/s", "imaginary / 1/s"), found.eigenvalues)])
