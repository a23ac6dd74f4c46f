"""What a package asks for, linked from this environment into another, without a network, and
nothing besides.
"""

from __future__ import annotations

import zipfile
from collections.abc import Iterable, Iterator
from email.parser import HeaderParser
from importlib.metadata import distribution, requires
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name


def of_wheel(wheel: Path) -> list[str]:
    """What a wheel asks for, by itself and for its extras."""
    with zipfile.ZipFile(wheel) as archive:
        (name,) = (name for name in archive.namelist() if name.endswith(".dist-info/METADATA"))
        return HeaderParser().parsestr(archive.read(name).decode()).get_all("Requires-Dist") or []


def link(requirements: Iterable[str], extra: str, site: Path) -> None:
    """Link what is asked for with an extra, and what that asks for in turn, into a folder of
    packages.
    """
    distributions: set[str] = set()
    waiting = list(_needed(requirements, {"", extra}))
    while waiting:
        requirement = waiting.pop()
        name = canonicalize_name(requirement.name)
        if name not in distributions:
            distributions.add(name)
            _link(name, site)
            waiting += _needed(requires(name) or (), {"", *requirement.extras})


def _needed(requirements: Iterable[str], extras: set[str]) -> Iterator[Requirement]:
    for requirement in map(Requirement, requirements):
        if requirement.marker is None or any(
            requirement.marker.evaluate({"extra": extra}) for extra in extras
        ):
            yield requirement


def _link(name: str, site: Path) -> None:
    package = distribution(name)
    for top in {path.parts[0] for path in package.files or ()} - {"..", "__pycache__"}:
        target = Path(str(package.locate_file(top)))
        if target.exists() and not (site / top).exists():
            (site / top).symlink_to(target)
