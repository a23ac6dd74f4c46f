"""Words of statements, and classes that run mechanisms: their docstrings, read from the sources.

`derive` needs SymPy and runs where something is derived; here its sources are parsed, not imported.
"""

from __future__ import annotations

import ast
import inspect
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources
from importlib.util import find_spec
from pathlib import Path

from planter.text_files import parse_toml, read_text

MECHANISM = "derive.Mechanism"
MEMBERS = (MECHANISM, "derive.Formulas", "derive.Paper")
"""Classes whose members are words of their own."""
_SENTENCE = re.compile(r"(?<=\.)\s+(?=[A-Z`(])|\n\n")
Node = ast.FunctionDef | ast.ClassDef | ast.Assign | ast.AnnAssign


@dataclass(frozen=True)
class WordPage:
    """A page of words: its text in Markdown, and full names by section."""

    head: str
    sections: Mapping[str, list[str]]


@dataclass(frozen=True)
class Word:
    """A word: its name in a statement, such as `m.pin`, how it is called, and its docstring."""

    name: str
    signature: str
    docstring: str

    @property
    def summary(self) -> str:
        """The first sentence in one line."""
        sentence = _SENTENCE.split(self.docstring.strip(), maxsplit=1)[0]
        return " ".join(sentence.split()).rstrip(":")

    @property
    def text(self) -> str:
        """Signature and docstring."""
        return f"{self.name}{self.signature}\n\n{self.docstring.strip()}\n"


@cache
def load_pages() -> dict[str, WordPage]:
    """Return the pages of words by name."""
    text = resources.files(__package__).joinpath("words.toml").read_text(encoding="utf-8")
    return {
        name: WordPage(
            page["head"],
            {title: list(map(_complete, names)) for title, names in page["sections"].items()},
        )
        for name, page in parse_toml(text, "words.toml").items()
    }


def _complete(name: str) -> str:
    return MECHANISM + name if name.startswith(".") else name


def shorten_name(name: str) -> str:
    """Return a name as statements have it.

    >>> shorten_name("derive.Mechanism.pin"), shorten_name("derive.Paper.shows")
    ('m.pin', 'Paper.shows')
    """
    return re.sub(r"^derive\.Mechanism\.", "m.", name).removeprefix("derive.")


@cache
def list_words() -> dict[str, str]:
    """Return the full names by the names in statements, in the order of the pages."""
    pages = load_pages().values()
    names = (name for page in pages for entries in page.sections.values() for name in entries)
    return {shorten_name(name): name for name in names}


def find_word(name: str) -> str | None:
    """Return the full name of a word from any of its names; None if it names none, or several.

    >>> find_word("pin"), find_word("m.pin"), find_word("derive.Body"), find_word("hinge")
    ('derive.Mechanism.pin', 'derive.Mechanism.pin', 'derive.Body', None)
    """
    words = list_words()
    if name in words:
        return words[name]
    matches = {full for full in words.values() if f".{full}".endswith(f".{name}")}
    return matches.pop() if len(matches) == 1 else None


def describe_words() -> dict[str, str]:
    """Return the first sentence of each word by its name in statements."""
    return {name: read_word(full).summary for name, full in list_words().items()}


def write_page(name: str) -> str:
    """Return a page of words as text: each section's words with their first sentences."""
    page = load_pages()[name]
    lines = [page.head.strip(), ""]
    for title, names in page.sections.items():
        lines += [f"## {title}", ""]
        lines += [f"* `{shorten_name(full)}`: {read_word(full).summary}" for full in names]
        lines.append("")
    return "\n".join(lines)


def read_word(name: str) -> Word:
    """Return a word by its full name."""
    for module, node, docstring in _locate(name):
        text = inspect.cleandoc(docstring).replace("``", "`")
        if isinstance(node, ast.ClassDef) and name not in MEMBERS:
            text += "".join(_describe_members(module, node))
        return Word(shorten_name(name), _format_signature(node), text)
    raise KeyError(name)


def _describe_members(module: str, node: ast.ClassDef) -> Iterator[str]:
    """Yield a line for each public method and property of a class."""
    members = [member for member in node.body if isinstance(member, ast.FunctionDef)]
    public = [member for member in members if not member.name.startswith("_")]
    if public:
        yield "\n"
    for member in public:
        signature = "" if member.decorator_list else _format_signature(member)
        word = Word(member.name, signature, ast.get_docstring(member) or "")
        yield f"\n.{member.name}{signature}: {word.summary}"


def _locate(name: str) -> Iterator[tuple[str, Node, str]]:
    """Yield the definition of a full name: its module, its syntax and its docstring."""
    parts = name.split(".")
    depth = next(n for n in range(len(parts), 0, -1) if _find_source(".".join(parts[:n])))
    module, members = ".".join(parts[:depth]), parts[depth:]
    places = list(_find_definitions(module, members[0]))
    for member in members[1:]:
        places = [inner for place in places for inner in _find_members(*place, member)]
    for home, node, following in places:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            yield home, node, ast.get_docstring(node) or ""
        else:
            yield home, node, _read_string(following)


Place = tuple[str, Node, ast.stmt | None]
"""A definition: its module, its syntax, and the statement that follows."""


def _find_definitions(module: str, name: str) -> Iterator[Place]:
    """Yield the definition of a name that a module defines or imports."""
    tree = _parse(module)
    yield from ((module, *match) for match in _search(tree.body, name))
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            for alias in node.names:
                if name == (alias.asname or alias.name) or alias.name == "*":
                    source = _resolve_import(module, node)
                    if _find_source(source):
                        yield from _find_definitions(
                            source, name if alias.name == "*" else alias.name
                        )


def _find_members(module: str, node: Node, _: ast.stmt | None, name: str) -> Iterator[Place]:
    """Yield the member of a class, or that of a class that it inherits from."""
    if isinstance(node, ast.ClassDef):
        yield from ((module, *match) for match in _search(node.body, name))
        for base in node.bases:
            for place in _find_definitions(module, ast.unparse(base).partition("[")[0]):
                yield from _find_members(*place, name)


def _search(body: list[ast.stmt], name: str) -> Iterator[tuple[Node, ast.stmt | None]]:
    for index, node in enumerate(body):
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            names = [node.name]
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            names = [
                item.id for part in targets for item in ast.walk(part) if isinstance(item, ast.Name)
            ]
        else:
            continue
        if name in names:
            yield node, next(iter(body[index + 1 : index + 2]), None)


def _read_string(node: ast.stmt | None) -> str:
    """Return the string that a statement consists of, empty for any other statement."""
    if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
        return str(node.value.value)
    return ""


def _format_signature(node: Node) -> str:
    """Return how a function is called, or a class made, empty for what is not called."""
    if isinstance(node, ast.ClassDef):
        methods = [method for method, _ in _search(node.body, "__init__")]
        return _format_signature(methods[0]).partition(" -> ")[0] if methods else ""
    if not isinstance(node, ast.FunctionDef) or any(
        ast.unparse(decorator).endswith("property") for decorator in node.decorator_list
    ):
        return ""
    arguments = re.sub(r"^self(, )?", "", ast.unparse(node.args))
    returned = f" -> {ast.unparse(node.returns)}" if node.returns else ""
    return f"({arguments}){returned}"


def _resolve_import(module: str, node: ast.ImportFrom) -> str:
    if not node.level:
        return node.module or ""
    source = _find_source(module)
    is_package = source is not None and source.name == "__init__.py"
    parts = module.split(".")
    base = parts[: len(parts) - node.level + is_package]
    return ".".join([*base, *([node.module] if node.module else [])])


@cache
def _parse(module: str) -> ast.Module:
    source = _find_source(module)
    assert source is not None
    return ast.parse(read_text(source))


@cache
def _find_source(module: str) -> Path | None:
    """Return the file of a module of `derive` or `planter`; None for what is no module of these."""
    root, *parts = module.split(".")
    if root not in ("derive", "planter"):
        return None
    spec = find_spec(root)
    if spec is None or spec.origin is None:
        return None
    path = Path(spec.origin).parent.joinpath(*parts)
    files = (path.with_suffix(".py"), path / "__init__.py")
    return next((file for file in files if file.is_file()), None)
