"""Names of the program's commands: sections of its help, groups, and names before they moved.

A command that no section names stands in the line of `MORE`, so that installed packages need no
entry.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class CommandGroup:
    """Commands below a common name, with the group's help."""

    help: str
    commands: tuple[str, ...]


SECTIONS = {
    "Begin": ("new", "simulate", "optimise", "studio"),
    "Check": ("audit", "calibrate", "prove"),
    "Make": ("gears", "cam", "export", "animate"),
    "Study": ("sweep", "tolerance", "diff", "sensitivity"),
}
"""Commands by the section of `planter --help`, in its order."""
MORE = ("derive", "linearise", "design", "about")
"""Commands and groups that `planter --help` has in one line, and `planter help commands` in full."""
GROUPS = {
    "design": CommandGroup(
        "Design clutches, pick-ups, linkages and gear trains.",
        ("clutch", "pickup", "synthesise", "train"),
    ),
    "about": CommandGroup(
        "Read about commands, names, works and this installation.",
        ("help", "explain", "example", "schema", "cite", "doctor", "bench"),
    ),
}
RENAMED = {
    "turn": "simulate",
    "move": "simulate",
    "validate": "simulate --check",
    "drive": "simulate --motor",
    "compare": "optimise --all-pairs",
    **{name: f"{group} {name}" for group, entry in GROUPS.items() for name in entry.commands},
}
"""Words that replace the first word of a call, by that word."""
SHORT = ("help", "example", "doctor")
"""Names that stay for those who type them every day: no note says that they moved."""


def current_words(words: Sequence[str]) -> list[str]:
    """Return the words of a call with the present name of its command.

    >>> current_words(["validate", "my.toml"]), current_words(["clutch", "field"])
    (['simulate', '--check', 'my.toml'], ['design', 'clutch', 'field'])
    """
    first, rest = list(words[:1]), list(words[1:])
    return [word for name in first for word in RENAMED.get(name, name).split(" ")] + rest


def current_result(name: str) -> str:
    """Return the name of a command's result, as `planter schema` and `planter cite` list it.

    >>> current_result("drive"), current_result("clutch field"), current_result("optimise")
    ('simulate motor', 'design clutch field', 'optimise')
    """
    return " ".join(word.removeprefix("--") for word in current_words(name.split()))


def describe_renaming(words: Sequence[str]) -> str | None:
    """Return the note on a call by an earlier name; None for a present one.

    >>> describe_renaming(["turn", "my.toml"])
    '`planter turn` is now `planter simulate`'
    """
    name = words[0] if words else ""
    if name not in RENAMED or name in SHORT:
        return None
    return f"`planter {name}` is now `planter {RENAMED[name]}`"
