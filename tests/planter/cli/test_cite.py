"""`planter cite`: every command that computes rests on works that there are, told in words and as
BibTeX.
"""

from __future__ import annotations

import re

from planter.cli.references import cite_work, format_bibtex, load_references
from planter.files import schema
from planter.version import __version__
from tests.support.cli import answer, refusal, run

TELLING = {
    "animate",
    "about bench",
    "cam",
    "about cite",
    "about doctor",
    "about example",
    "about explain",
    "export c",
    "export casadi",
    "export jax",
    "export rust",
    "export fmu",
    "export motion",
    "about help",
    "optimise-least",
    "about schema",
    "new",
    "simulate check",
}
"""Commands that show, check or pass on what others compute."""


def missing(commands: dict[str, list[str]]) -> set[str]:
    """Works that are named and not there."""
    return {key for keys in commands.values() for key in keys} - load_references().works.keys()


def test_computing_commands_cite_works() -> None:
    index = load_references()
    assert set(schema.load_result_types()) - {"optimise least"} == index.commands.keys() | (
        TELLING - {"optimise-least"}
    )
    assert not missing(dict(index.commands))
    assert missing({"simulate": ["wong2017"]}) == {"wong2017"}


def test_a_command_s_works_begin_with_this_program() -> None:
    keys = [work["key"] for work in answer("cite optimise")["works"]]
    assert keys[0] == "planter"
    assert {"wang2017", "casadi", "ipopt", "goldberg1989", "daqp"} <= set(keys)
    assert __version__ in cite_work("planter").text
    assert [work["key"] for work in answer("cite clutch engage")["works"]][1:3] == [
        "shi2021",
        "hunt1975",
    ]


def test_entries_of_bibtex_are_whole() -> None:
    entry = re.compile(r"@[a-z]+\{([a-z0-9]+),\n(  [a-z]+ = \{.*\},\n)*  [a-z]+ = \{.*\}\n\}")
    text = run("cite simulate --bibtex")[1]
    assert [match.group(1) for match in entry.finditer(text)] == [
        "planter",
        "wang2017",
        "casadi",
        "sympy",
        "scipy",
    ]
    for key in load_references().works:
        work = cite_work(key).bibtex
        assert entry.fullmatch(work), work
        assert work.count("{") == work.count("}")
        assert "  for = " not in work
    assert not entry.fullmatch(format_bibtex("a", {"type": "misc", "title": "x"})[:-1])


def test_unknown_names_are_refused() -> None:
    assert "did you mean wang2017" in refusal("cite wang2071")
    assert "planter about cite lists the works" in refusal("cite zzzz")
