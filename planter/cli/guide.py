"""What `planter help` prints: topics on what commands share, pages of the documentation, words of
statements.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from importlib import resources
from typing import TYPE_CHECKING, Any

from planter import paths
from planter.cli import words
from planter.cli.results import Topics
from planter.errors import InputError
from planter.files import documents

if TYPE_CHECKING:
    from planter.cli.app import Menu

COMMANDS = "commands"
"""Name of the page of all commands, which is made of their summaries."""
_FOLDER = resources.files(__package__).joinpath("topics")


def list_topics() -> list[str]:
    """Return the names of the topics, sorted."""
    return sorted(
        page.name.removesuffix(".md") for page in _FOLDER.iterdir() if page.name.endswith(".md")
    )


def list_pages() -> dict[str, str]:
    """Return the titles of pages by name: that of commands, those of words and of the
    documentation.
    """
    heads = {name: page.head.split("\n")[0] for name, page in words.load_pages().items()}
    titles = {name: head.removeprefix("# ") for name, head in heads.items()}
    return {COMMANDS: "All commands, by section"} | titles | documents.list_pages()


def describe_guide() -> Topics:
    """Return all that there is to read."""
    return Topics(list_topics(), list_pages(), words.describe_words())


def read_guide(name: str) -> str:
    """Return the text of a topic, page or word. Raises InputError for an unknown name."""
    if name in list_topics():
        return _FOLDER.joinpath(f"{name}.md").read_text(encoding="utf-8")
    if name in words.load_pages():
        return words.write_page(name)
    if name in documents.list_pages():
        return documents.read_page(name)
    if (word := words.find_word(name)) is not None:
        return words.read_word(word).text
    short = [*list_topics(), *list_pages()]
    allowed = f"it must be one of {', '.join(short)}, or a word of statements: `planter help`"
    hint = paths.suggest_names(name, [*short, *words.list_words()], allowed)
    raise InputError.for_value("NAME", name, hint)


def describe_commands(application: Menu) -> str:
    """Return the summaries of all commands by section, those of groups below their group."""
    parts = ["`planter COMMAND --help` describes one of them."]
    for title, names in application.list_sections().items():
        summaries = dict(_list_summaries(application, names))
        width = max(map(len, summaries))
        rows = (f"    {call:{width}}  {text}" for call, text in summaries.items())
        parts += ["", f"{title}:", "", *rows]
    return "\n".join(parts)


def _list_summaries(
    group: Any, names: Iterable[str], prefix: str = "planter"
) -> Iterator[tuple[str, str]]:
    """Yield the call and the summary of commands of a group, and of those below them."""
    for name in names:
        command, call = group.commands[name], f"{prefix} {name}"
        yield call, command.get_short_help_str(limit=100)
        yield from _list_summaries(command, getattr(command, "commands", ()), call)


def format_guide(guide: Topics) -> str:
    """Return topics, pages and words as text, a line each."""
    pages = words.load_pages()
    parts = ["Topics, for all commands:", *(f"  {name}" for name in guide.topics), "", "Pages:"]
    width = max(map(len, guide.pages))
    parts += [f"  {name:{width}}  {title}" for name, title in guide.pages.items()]
    for page in pages.values():
        for title, names in page.sections.items():
            short = list(map(words.shorten_name, names))
            width = max(map(len, short))
            parts += ["", f"{title}:", *(f"  {n:{width}}  {guide.words[n]}" for n in short)]
    return "\n".join([*parts, "", "planter help NAME prints one of them."])
