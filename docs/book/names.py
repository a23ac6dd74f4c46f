"""The page of public names: what `planter` and `derive` offer, with their docstrings."""

from __future__ import annotations

import inspect
from collections.abc import Iterator

import derive
import planter
from book import reference

HEAD = """\
# Public names

`planter` is numeric: machines, their calls, results as records. `derive` is symbolic: the words that a mechanism,
formulas or a paper of your own are stated with (extra `derive`). Three pages hold what belongs to one task:
[stating a mechanism](mechanism.md), [formulas and papers](papers.md), [running a mechanism](running.md). What is on
none of these pages may change without notice.
"""


def public(package: object) -> dict[str, object]:
    """The public names of a package with what they stand for."""
    return {name: getattr(package, name) for name in package.__all__ if not name.startswith("__")}


def directive(package: str, name: str, found: object) -> Iterator[str]:
    """What Sphinx is to show of a name."""
    kind = (
        "autoclass" if inspect.isclass(found) else "autofunction" if callable(found) else "autodata"
    )
    yield f".. {kind}:: {package}.{name}"
    if kind == "autodata":
        yield "   :no-value:"
    if kind == "autoclass" and package == "planter" and not issubclass(found, Exception):
        yield "   :members:"
    yield ""


def page() -> str:
    """The page."""
    text, elsewhere = [HEAD], {name for task in reference.PAGES for name in reference.names(task)}
    for package in (planter, derive):
        text += [f"## `{package.__name__}`", "", "```{eval-rst}"]
        for name, found in public(package).items():
            if f"{package.__name__}.{name}" not in elsewhere:
                text += directive(package.__name__, name, found)
        text += ["```", ""]
    return "\n".join(text)
