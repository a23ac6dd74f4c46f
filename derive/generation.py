"""Content of generated folders, as texts by path: of this project, or of what a user names."""

from __future__ import annotations

import sys
from collections.abc import Callable, Collection, Iterable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from types import ModuleType

from . import papers
from .audit.verdicts import FILES, find_cases, judge_cases
from .discovery import (
    GROUPS,
    TARGETS,
    find_entry_points,
    import_modules,
    list_offers,
    load_user_modules,
)
from .emit.folder import Target, built_in, render_texts, select_targets
from .generated_folder import OwnError, blame_user_file
from .mechanics import gearing
from .mechanics.gearing.families import FAMILIES
from .mechanics.gearing.pitch_curve import PitchCurve
from .model import System

NOTHING = (
    "nothing to derive in it; a file offers SYSTEMS (a tuple of functions that derive a model "
    "each), SYSTEM (a model), "
    "CASE (a paper and what it is tried against), or a family of pitch curves under @register"
)


def derive_code(names: Collection[str] = ()) -> dict[str, str]:
    """Path inside `generated/` -> content: models, families and targets of this package, none of an
    installed one.
    """
    targets = _chosen(built_in(), names)
    return render_texts(
        derive_models((*import_modules(gearing), *import_modules(papers))),
        FAMILIES.values(),
        targets,
    )


def derive_user_code(name: str, target_names: Collection[str] = ()) -> tuple[dict[str, str], Path]:
    """Return the same for a file, a folder or an installed package's offer, and the folder next to
    it to write to.

    ``target_names`` are names of targets that are written in addition to those that always are.
    Raises OwnError where there is nothing to derive, or where it raises.
    """
    path = Path(name)
    targets = _chosen(
        (*built_in(), *(entry.load().TARGET for entry in find_entry_points(TARGETS).values())),
        target_names,
    )
    if path.suffix == ".urdf" and path.is_file():
        return _derive_robot(path, targets), path.parent / "generated"
    if path.exists():
        with blame_user_file(path), load_user_modules(path) as entry:
            return _code_of(name, entry, targets), (
                path.parent if path.is_file() else path
            ) / "generated"
    offers = find_entry_points(*GROUPS)
    if name not in offers:
        hint = f" (they offer {', '.join(sorted(offers))})" if offers else ""
        raise OwnError(
            f"{name}: there is no such file or folder, and no installed package offers it{hint}"
        )
    module = offers[name].load()
    return _code_of(name, [module], targets), _file(module).parent / "generated"


def _derive_robot(path: Path, targets: Sequence[Target]) -> dict[str, str]:
    """Return the statement of a robot's file, and the functions of it."""
    from .robots import RobotError, write_statement

    try:
        name, text = write_statement(path)
    except RobotError as error:
        raise OwnError(str(error)) from None
    with TemporaryDirectory() as folder:
        statement = Path(folder, f"{name}_statement.py")
        statement.write_text(text, encoding="utf-8")
        with blame_user_file(path), load_user_modules(statement) as entry:
            return {statement.name: text} | _code_of(str(path), entry, targets)


TRIAL = """\
from derive.audit.texts.trial import read_trial

CASE = read_trial({text!r}, {against!r}, {names!r})
"""
"""Module that states the case of a text: a process that judges its equations runs it."""
SKELETON = "names.toml"


def derive_text(text: Path, against: Path, names: Path | None = None) -> dict[str, str]:
    """Path -> content: the verdicts on a text, the functions of what it is compared with, and its
    names.

    Raises OwnError for a text, a file of names or a mechanism that cannot be used.
    """
    from .audit.texts.trial import format_skeleton

    paths = [str(path.resolve()) if path is not None else None for path in (text, against, names)]
    with TemporaryDirectory() as folder:
        module = Path(folder, "text_on_trial.py")
        module.write_text(
            TRIAL.format(text=paths[0], against=paths[1], names=paths[2]), encoding="utf-8"
        )
        with blame_user_file(against), load_user_modules(module) as entry:
            (case,) = find_cases(entry).values()
            return {
                **_code_of(str(text), entry, _chosen(built_in(), ())),
                SKELETON: format_skeleton(case),
            }


def _chosen(targets: Iterable[Target], names: Collection[str]) -> list[Target]:
    try:
        return select_targets(targets, names)
    except ValueError as error:
        raise OwnError(f"--target: {error}") from None


def derive_models(modules_: Iterable[ModuleType]) -> list[System]:
    """The models that modules offer, derived. Raises TypeError where one offers something else."""
    modules_ = tuple(modules_)
    systems = [
        system() if callable(system) else system
        for offers in list_offers(modules_, "SYSTEMS")
        for system in offers
    ]
    systems += list_offers(modules_, "SYSTEM")
    for system in systems:
        if not isinstance(system, System):
            raise TypeError(f"SYSTEMS and SYSTEM offer models, and {system!r} is not a System")
    return systems


def _code_of(
    name: str, modules_: Sequence[ModuleType], targets: Sequence[Target]
) -> dict[str, str]:
    systems, families, verdict_files = (
        derive_models(modules_),
        _families(modules_),
        _judged(modules_),
    )
    systems += _tried_against(modules_, {system.name for system in systems})
    if not systems and not families and not verdict_files:
        raise OwnError(f"{name}: {NOTHING}")
    written = (
        render_texts(systems, families, [*targets, *list_offers(modules_, "TARGET")])
        if systems or families
        else {}
    )
    return written | verdict_files


def _tried_against(modules_: Sequence[ModuleType], names: Collection[str]) -> list[System]:
    """The models that papers of modules are tried against, each once, but for those that are
    known.
    """
    subjects = (case.subject.model() for case in find_cases(modules_).values())
    return list(
        {
            model.name: model for model in subjects if model is not None and model.name not in names
        }.values()
    )


def _judged(modules_: Sequence[ModuleType]) -> dict[str, str]:
    """The verdicts on the papers of modules, if there are any."""
    return judge_cases(modules_) if find_cases(modules_) else {}


def _families(modules_: Iterable[ModuleType]) -> list[PitchCurve]:
    """The families that were registered from the folders of some modules."""
    folders = {_file(module).parent for module in modules_}
    return [
        family
        for family in FAMILIES.values()
        if _file(sys.modules[type(family).__module__]).parent in folders
    ]


def _file(module: ModuleType) -> Path:
    return Path(str(module.__file__)).resolve()


def judge_papers(committed: Path | None = None) -> dict[str, str]:
    """Path inside `generated/` -> content: what the audit found of every equation and of the
    laws.
    """
    return judge_cases(import_modules(papers), committed)


PARTS: dict[str, Callable[[Path | None], dict[str, str]]] = {
    "code": lambda _: derive_code(),
    "audit": judge_papers,
}
VERDICTS = frozenset(FILES)
