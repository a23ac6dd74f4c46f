"""Numbers far beyond any machine's: an answer, or one sentence; never a warning of a library, never
a traceback.
"""

import warnings
from collections.abc import Callable, Mapping

import pytest

from planter.errors import InputError
from planter.files.document import Document
from planter.papers.clutch.file import load_clutch
from planter.papers.mapping.file import load_poses
from planter.papers.pickup.file import load_pickup as load_pickup
from planter.papers.planting.file import load as load_device
from tests.support import cli, own

Load = Callable[[str, Mapping[str, float]], Document]
MACHINES: dict[str, tuple[Load, tuple[str, ...]]] = {
    "wang2017": (load_device, ("simulate",)),
    "shi2021": (load_clutch, ("clutch", "geometry")),
    "yu2023": (load_pickup, ("pickup",)),
    "sun2019": (load_poses, ("synthesise",)),
}
EXTREMES = (1e-308, 1e308, 0.0, -1.0, 1e-15, 1e15)
SAMPLE = [
    ("yu2023", "needle.width_mm", 1e-308),
    ("yu2023", "tray.cell_bottom_mm", 1e-308),
    ("yu2023", "needle.width_mm", 1e-15),
    ("shi2021", "shaft.overhang_mm", 1e15),
]


def refuses(load: Load, machine: str, path: str, value: float) -> bool:
    try:
        load(machine, {path: value})
    except InputError:
        return True
    return False


def check_outcome(machine: str, path: str, value: float) -> None:
    """Asserts that a command ends with an answer, or with exit code 1 or 2 and one sentence."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        code, out, err = cli.run(
            *MACHINES[machine][1], machine, "--set", f"{path}={value!r}", "--json"
        )
    assert code in (0, 1, 2), (path, value, err)
    assert "Traceback" not in err
    assert "Infinity" not in out
    assert "NaN" not in out
    if code:
        assert len(err.strip().splitlines()) == 1, (path, value, err)


@pytest.mark.parametrize("machine", MACHINES)
def test_no_number_has_a_vanishing_square(machine: str) -> None:
    load, _ = MACHINES[machine]
    assert [
        path for path in load(machine, {}).numbers() if not refuses(load, machine, path, 1e-308)
    ] == []


def test_endless_cycle_speed_is_refused() -> None:
    with pytest.raises(InputError, match="omega_rpm"):
        own.file("slider_crank", omega_rpm=1e-308)


@pytest.mark.parametrize(("machine", "path", "value"), SAMPLE)
def test_extreme_number_gets_an_answer_or_a_sentence(machine: str, path: str, value: float) -> None:
    assert path in MACHINES[machine][0](machine, {}).numbers()
    check_outcome(machine, path, value)


@pytest.mark.long
@pytest.mark.parametrize("value", EXTREMES)
@pytest.mark.parametrize("machine", MACHINES)
def test_every_extreme_number_gets_an_answer_or_a_sentence(machine: str, value: float) -> None:
    for path in MACHINES[machine][0](machine, {}).numbers():
        check_outcome(machine, path, value)
