"""`python -m tests.support.licences` writes docs/licences.md, what an installation brings, under
which licences, and docs/installation.json, the size of the one that README names.

The list is read from the environment that runs it, which must hold `planter` with all the extras
for users.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Mapping
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from tests.support.structure import ROOT

PAGE = ROOT / "docs" / "licences.md"
SIZE = ROOT / "docs" / "installation.json"
INSTALLED = ("derive", "studio")
"""Extras of the installation that README names."""
PACKED = ("planter", "derive", "generated", "docs")
"""Folders of the wheel."""
EXTRAS = ("derive", "studio", "notebook", "compiler", "parquet", "cluster", "step")
"""Extras for those who use the package; the others are for those who work on it."""
CLASSIFIER = "License :: OSI Approved :: "
HEAD = """\
# Licences of what is installed

`planter` is under Apache-2.0, and nobody else's code is in it. `pip install planter` brings the packages below, with
the licences that their own metadata name, at the versions that the tests pass with. An extra is named where a package
comes with it alone. Some wheels hold libraries with licences of their own, as their folders tell; CasADi's holds IPOPT
(EPL-2.0), MUMPS (CeCILL-C) and SUNDIALS (BSD-3-Clause) among others. Written by `python -m tests.support.licences`.

| package | version | licence | extra |
|---|---|---|---|
"""


def needed(name: str, extra: str = "") -> Iterator[str]:
    """Names of the packages that a package needs here, with one of its extras, those of its needs
    after it.
    """
    for text in distribution(name).requires or ():
        requirement = Requirement(text)
        if requirement.marker is None or requirement.marker.evaluate({"extra": extra}):
            yield canonicalize_name(requirement.name)
            for inner in requirement.extras:
                yield from needed(requirement.name, inner)


def closure(extra: str) -> set[str]:
    """Everything that an installation with an extra brings; none for `""`."""
    names, new = set[str](), {"planter"}
    while new:
        name = new.pop()
        new |= set(needed(name, extra if name == "planter" else "")) - names
        names |= new
    return names


def licence(metadata: Mapping[str, str], classifiers: list[str]) -> str:
    """The licence that a package's metadata name: as an expression, else by classifier, else in a
    line.

    >>> licence({"License-Expression": "MIT", "License": "a long text"}, [])
    'MIT'
    >>> licence({"License": "BSD"}, ["License :: OSI Approved :: BSD License"])
    'BSD License'
    >>> licence({"License": "LGPL-3.0"}, []), licence({}, [])
    ('LGPL-3.0', 'not named')
    """
    if "License-Expression" in metadata:
        return metadata["License-Expression"]
    licences = [
        classifier.removeprefix(CLASSIFIER)
        for classifier in classifiers
        if classifier.startswith(CLASSIFIER)
    ]
    return ", ".join(licences) or metadata.get("License", "not named").splitlines()[0]


def row(name: str, extra: str) -> str:
    """A package's row of the page."""
    package = distribution(name)
    licence_names = licence(
        {key: package.metadata[key] for key in package.metadata},
        package.metadata.get_all("Classifier") or [],
    )
    return f"| {package.metadata['Name']} | {package.version} | {licence_names} | {extra} |\n"


def measure_installation() -> dict[str, float | int]:
    """Return the size of all files of an installation with the extras of README, and the number of
    its packages.

    Raises PackageNotFoundError.
    """
    names = set[str]().union(*(closure(extra) for extra in INSTALLED))
    listed = [file.locate() for name in names for file in distribution(name).files or ()]
    packed = [file for folder in PACKED for file in (ROOT / folder).rglob("*")]
    paths = {Path(str(path)) for path in (*listed, *packed)}
    size = sum(path.stat().st_size for path in paths if path.is_file())
    return {"size_GB": round(size / 1e9, 3), "packages": len(names)}


def page() -> str:
    """The page: what the package itself needs first, then what each extra adds.

    Raises PackageNotFoundError.
    """
    runtime = closure("")
    rows = [row(name, "") for name in sorted(runtime)]
    for extra in EXTRAS:
        new = closure(extra) - runtime
        rows += [row(name, extra) for name in sorted(new)]
        runtime |= new
    return HEAD + "".join(rows)


if __name__ == "__main__":
    try:
        PAGE.write_text(page(), encoding="utf-8")
        SIZE.write_text(json.dumps(measure_installation()) + "\n", encoding="utf-8")
    except PackageNotFoundError as missing:
        sys.exit(f"{missing}: pip install '.[{','.join(EXTRAS)}]' first")
