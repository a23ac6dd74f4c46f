"""`planter help` and the shell's completion."""

from __future__ import annotations

import os
import re
import subprocess
import sys

import pytest

from planter.cli.commands import list_topics
from planter.kernels import backends
from tests.support.cli import answer, refusal, run

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
    assert set(answer("help")["topics"]) == TOPICS == set(list_topics())
    for topic in TOPICS:
        result = answer("help", topic)
        assert result.keys() == {"topic", "text"}
        assert max(map(len, result["text"].splitlines())) <= 125


def test_unknown_topic_is_refused_with_suggestion() -> None:
    assert "did you mean units?" in refusal("help unit")
    assert "it must be one of completion, environment" in refusal("help zzz")


def test_commands_in_topics_exist() -> None:
    command_names = commands(
        "\n".join(
            f"    planter {line.split()[0]}"
            for line in run("--help")[1].splitlines()
            if line[2:3].isalpha()
        )
    )
    for topic in TOPICS:
        assert commands(answer("help", topic)["text"]) <= command_names
    assert not commands("    planter simulat x") <= command_names


@pytest.mark.parametrize("group", [(), ("clutch",), ("export",)])
def test_summaries_of_commands_are_whole_sentences(group: tuple[str, ...]) -> None:
    lines = run(*group, "--help")[1].partition("Commands:\n")[2].splitlines()
    summaries = dict(line.split(maxsplit=1) for line in lines if line)
    assert len(summaries) == len(lines) > 2
    assert not {
        name: text
        for name, text in summaries.items()
        if not text.endswith(".") or text.endswith("...")
    }


def test_variables_on_page_are_read(monkeypatch: pytest.MonkeyPatch) -> None:
    assert "PLANTER_KERNELS" in answer("help environment")["text"]
    monkeypatch.setenv("PLANTER_KERNELS", backends.BACKENDS[-1])
    assert backends.list_allowed() == backends.BACKENDS[-1:]


def test_shell_completion_continues_words() -> None:
    variables = {
        "_PLANTER_COMPLETE": "complete_bash",
        "COMP_WORDS": "planter simu",
        "COMP_CWORD": "1",
    }
    done = subprocess.run(
        [
            sys.executable,
            "-c",
            "import sys; sys.argv[0] = 'planter'; from planter.cli import main; main()",
        ],
        env=os.environ | variables,
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.split() == ["simulate"]
