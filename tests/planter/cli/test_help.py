"""`planter help`: topics, pages of the documentation, words of statements as `derive` has them."""

from __future__ import annotations

import inspect
import re
import subprocess
import sys
from pkgutil import resolve_name

import pytest

from planter import menu
from planter.cli import guide, words
from planter.kernels import backends
from tests.support.cli import answer, refusal
from tests.support.structure import ROOT

TOPICS = {
    "completion",
    "environment",
    "exit-codes",
    "json",
    "machine-files",
    "output-files",
    "own-mechanisms",
    "units",
}


def commands(text: str) -> set[str]:
    """First words of the calls of `planter` that stand in lines of their own."""
    return set(re.findall(r"^    planter ([a-z]+)", text, re.MULTILINE))


def test_topics_are_listed_and_printed() -> None:
    assert set(answer("help")["topics"]) == TOPICS == set(guide.list_topics())
    for topic in TOPICS:
        result = answer("help", topic)
        assert result.keys() == {"topic", "text"}
        assert max(map(len, result["text"].splitlines())) <= 125


def test_unknown_topic_is_refused_with_suggestion() -> None:
    assert "did you mean environment?" in refusal("help environmen")
    assert "did you mean m.spring" in refusal("help m.sprin")
    assert "it must be one of completion, environment" in refusal("help zzzzz")


def test_pages_of_the_documentation_are_printed() -> None:
    pages = answer("help")["pages"]
    for name in ("measures", "gears", "dynamics"):
        text = (ROOT / "docs" / f"{name}.md").read_text(encoding="utf-8")
        assert text.startswith(f"# {pages[name]}\n")
        assert answer("help", name)["text"] == text
    assert pages["mechanism"] == "Stating a mechanism"
    assert "* `m.pin`: State a revolute joint" in answer("help mechanism")["text"]


def test_names_of_topics_pages_and_words_are_different() -> None:
    index = answer("help")
    names = [*index["topics"], *index["pages"], *index["words"]]
    assert len(set(names)) == len(names) > 100


def test_words_are_those_of_derive() -> None:
    """Names, parameters and docstrings read from the sources are those of the objects."""
    for name, full in words.list_words().items():
        item = resolve_name(full)
        word = words.read_word(full)
        assert word.name == name
        assert len(word.summary.split()) > 3
        documented = inspect.getdoc(item) or inspect.getdoc(resolve_name(full.rpartition(".")[0]))
        assert word.docstring.startswith(str(documented).replace("``", "`")), full
        if inspect.isfunction(item):
            parameters = inspect.signature(item).parameters.keys() - {"self"}
            assert all(re.search(rf"\b{part}\b", word.signature) for part in parameters), full


def test_word_answers_to_its_names() -> None:
    texts = {answer("help", name)["text"] for name in ("m.pin", "pin", "derive.Mechanism.pin")}
    assert len(texts) == 1
    assert "m.pin(name: str, on: Body, by: Body, at: Point" in texts.pop()
    assert answer("help Body")["text"] == answer("help derive.Body")["text"]


def test_words_need_neither_sympy_nor_derive() -> None:
    code = (
        "import sys; from planter.cli import guide; guide.describe_guide(); "
        "print({'sympy', 'derive'} & sys.modules.keys())"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "set()\n"


def test_commands_in_topics_exist() -> None:
    listed = {name for names in menu.SECTIONS.values() for name in names}
    listed |= {*menu.MORE, *menu.SHORT}
    for topic in TOPICS:
        assert commands(answer("help", topic)["text"]) <= listed
    assert not commands("    planter simulat x") <= listed


def test_variables_on_page_are_read(monkeypatch: pytest.MonkeyPatch) -> None:
    assert "PLANTER_KERNELS" in answer("help environment")["text"]
    monkeypatch.setenv("PLANTER_KERNELS", backends.BACKENDS[-1])
    assert backends.list_allowed() == backends.BACKENDS[-1:]
