"""The page of models: what each generated one is, where it is from, and what it assumes."""

from __future__ import annotations

from collections.abc import Iterator

from planter.kernels import generated

HEAD = """\
# Models and what they assume

Every model that was derived, as its functions say it; reports repeat the assumptions of theirs, and
`planter simulate --lift` lifts those of the planting device one by one.
"""


def names() -> list[str]:
    """Models that were derived; beside them the records of the audit are generated."""
    return [name for name in generated.names() if "title" in generated.sidecar(name)]


def section(name: str) -> Iterator[str]:
    """A model with its title, source and assumptions."""
    sidecar = generated.sidecar(name)
    yield f"\n## `{name}`\n\n{sidecar['title']}; source: {sidecar['source']}.\n"
    yield from (f"* {one}" for one in sidecar.get("assumptions", ()))


def page() -> str:
    """The page."""
    return "\n".join([HEAD, *(line for name in names() for line in section(name))]) + "\n"
