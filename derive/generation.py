"""Content of generated folders, as texts by path: of this project, or of what a user names."""

from __future__ import annotations

import sys
from collections.abc import Callable, Collection, Iterable, Sequence
from pathlib import Path
from types import ModuleType

from . import gearing, papers, systems
from .audit.verdicts import FILES, cases, verdicts
from .discovery import GROUPS, TARGETS, installed, loaded, modules, offered
from .emit.folder import Target, built_in, chosen, texts
from .gearing.families import FAMILIES
from .gearing.pitch_curve import PitchCurve
from .generated_folder import OwnError, blamed
from .model import System

NOTHING = (
    "nothing to derive in it; a file offers SYSTEMS (a tuple of functions that derive a model each), SYSTEM (a model), "
    "CASE (a paper and what it is tried against), or a family of pitch curves under @register"
)


def code(asked: Collection[str] = ()) -> dict[str, str]:
    """Path inside `generated/` -> content: models, families and targets of our own, none of an installed package."""
    targets = _chosen(built_in(), asked)
    return texts(models((*modules(gearing), *modules(systems), *modules(papers))), FAMILIES.values(), targets)


def code_of(what: str, asked: Collection[str] = ()) -> tuple[dict[str, str], Path]:
    """The same of a file, of a folder, or of what an installed package offers, and the folder beside it to write to.

    ``asked`` are names of targets that are written beside those that always are. Raises OwnError where there is
    nothing to derive, or where it raises.
    """
    path = Path(what)
    targets = _chosen((*built_in(), *(found.load().TARGET for found in installed(TARGETS).values())), asked)
    if path.exists():
        with blamed(path), loaded(path) as found:
            return _code_of(what, found, targets), (path.parent if path.is_file() else path) / "generated"
    known = installed(*GROUPS)
    if what not in known:
        offers = f" (they offer {', '.join(sorted(known))})" if known else ""
        raise OwnError(f"{what}: there is no such file or folder, and no installed package offers it{offers}")
    room = known[what].load()
    return _code_of(what, [room], targets), _file(room).parent / "generated"


def _chosen(known: Iterable[Target], asked: Collection[str]) -> list[Target]:
    try:
        return chosen(known, asked)
    except ValueError as error:
        raise OwnError(f"--target: {error}") from None


def models(rooms: Iterable[ModuleType]) -> list[System]:
    """The models that modules offer, derived. Raises TypeError where one offers something else."""
    rooms = tuple(rooms)
    found = [one() if callable(one) else one for some in offered(rooms, "SYSTEMS") for one in some]
    found += offered(rooms, "SYSTEM")
    for one in found:
        if not isinstance(one, System):
            raise TypeError(f"SYSTEMS and SYSTEM offer models, and {one!r} is not a System")
    return found


def _code_of(what: str, rooms: Sequence[ModuleType], targets: Sequence[Target]) -> dict[str, str]:
    found, families, judged = models(rooms), _families(rooms), _judged(rooms)
    found += _tried_against(rooms, {one.name for one in found})
    if not found and not families and not judged:
        raise OwnError(f"{what}: {NOTHING}")
    written = texts(found, families, [*targets, *offered(rooms, "TARGET")]) if found or families else {}
    return written | judged


def _tried_against(rooms: Sequence[ModuleType], known: Collection[str]) -> list[System]:
    """The models that papers of modules are tried against, each once, but for those that are known."""
    subjects = (case.subject.model() for case in cases(rooms).values())
    return list({one.name: one for one in subjects if one is not None and one.name not in known}.values())


def _judged(rooms: Sequence[ModuleType]) -> dict[str, str]:
    """The verdicts on the papers of modules, if there are any."""
    return verdicts(rooms) if cases(rooms) else {}


def _families(rooms: Iterable[ModuleType]) -> list[PitchCurve]:
    """The families that were registered from the folders of some modules."""
    folders = {_file(room).parent for room in rooms}
    return [family for family in FAMILIES.values() if _file(sys.modules[type(family).__module__]).parent in folders]


def _file(module: ModuleType) -> Path:
    return Path(str(module.__file__)).resolve()


def judge_papers(committed: Path | None = None) -> dict[str, str]:
    """Path inside `generated/` -> content: what the audit found of every equation and of the laws."""
    return verdicts(modules(papers), committed)


PARTS: dict[str, Callable[[Path | None], dict[str, str]]] = {"code": lambda _: code(), "audit": judge_papers}
VERDICTS = frozenset(FILES)
