"""`python -m tests.support.names CHECK` lists names that say too little; their numbers may only fall.

`tests.support.size` holds the totals. The checks are

* vague: variables, parameters, attributes, functions and imports that are named by a word of
  `VAGUE` alone;
* one_word: public functions of a module that are one word, which says nothing once it is imported;
* duplicate: public classes whose name another class of `planter` or `derive` has;
* undocumented: public classes, functions and methods without a docstring;
* shadow: local variables named like a function of their module, or an imported one;
* fragment: docstrings that begin with a preposition or a pronoun, so that they need the name to be
  understood.

Tests count for vague and shadow alone.
"""

from __future__ import annotations

import argparse
import ast
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from operator import attrgetter
from pathlib import Path

from tests.support.structure import FOUNDATION, ROOT

PACKAGES = ("planter", "derive", "tests")
CHECKS = ("vague", "one_word", "duplicate", "undocumented", "shadow", "fragment")
VAGUE = re.compile(
    r"_*(along|apart|around|asked|beside|drawn|every|found|given|held|here|kept|known|least|made|mine|most|near|of|one|others"
    r"|own|said|several|shown|there|told|tried|two|under|wanted|what|which|whole|within)_*"
)
"""Words that say what happened to a value, or point at it, and not what it is."""
FRAGMENT = re.compile(
    r"(Of|As|Where|What|Whose|Which|With|Without|From|In|At|On|By|For|The "
    r"same|Those|It|They|That)\b"
)
UNSEEN = {"property", "cached_property", "overload", "override", "setter"}
"""Decorators of functions that need neither a verb nor a docstring of their own."""


@dataclass(frozen=True)
class Finding:
    """A name or docstring that a check counts: the check, the package, the place as `path:line`,
    and the name.
    """

    check: str
    package: str
    place: str
    name: str


@dataclass(frozen=True)
class Source:
    """A module's path below the project, and its text."""

    path: str
    text: str

    @cached_property
    def tree(self) -> ast.Module:
        """The syntax tree."""
        return ast.parse(self.text)

    @property
    def package(self) -> str:
        """Package below `planter` or `derive`; the tests are one."""
        parts = self.path.split("/")
        if parts[0] == "tests":
            return "tests"
        return f"{parts[0]}.{parts[1] if len(parts) > 2 else FOUNDATION}"

    def finding(self, check: str, line: int, name: str) -> Finding:
        """Return the finding of a check at a line."""
        return Finding(check, self.package, f"{self.path}:{line}", name)


def read_sources(root: Path = ROOT, packages: Iterable[str] = PACKAGES) -> Iterator[Source]:
    """Yield all modules of packages below a folder, in the order of their paths."""
    for package in packages:
        for path in sorted((root / package).rglob("*.py")):
            yield Source(path.relative_to(root).as_posix(), path.read_text(encoding="utf-8"))


def find_names(sources: Iterable[Source]) -> Iterator[Finding]:
    """Yield the findings of all checks."""
    classes: dict[str, list[Finding]] = {}
    for source in sources:
        yield from _find_vague(source)
        yield from _find_shadows(source)
        if source.package == "tests":
            continue
        yield from _find_in_definitions(source, source.tree, is_module=True)
        for node in source.tree.body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                classes.setdefault(node.name, []).append(
                    source.finding("duplicate", node.lineno, node.name)
                )
    for same in classes.values():
        if len(same) > 1:
            yield from same


def _find_vague(source: Source) -> Iterator[Finding]:
    for node in ast.walk(source.tree):
        for name in _bound_names(node):
            if VAGUE.fullmatch(name):
                yield source.finding("vague", getattr(node, "lineno", 1), name)


def _find_shadows(source: Source) -> Iterator[Finding]:
    """Yield variables of functions that take the name of a function, whose names are verbs."""
    functions: set[str] = set()
    for node in source.tree.body:
        if isinstance(node, ast.FunctionDef):
            functions.add(node.name)
        elif isinstance(node, ast.ImportFrom):
            functions.update(alias.asname or alias.name for alias in node.names)
    verbs = {name for name in functions if "_" in name.strip("_") and name.islower()}
    for function in ast.walk(source.tree):
        if isinstance(function, ast.FunctionDef | ast.Lambda):
            for node in ast.walk(function):
                is_verb = isinstance(node, ast.Name) and node.id in verbs
                if is_verb and isinstance(node.ctx, ast.Store):
                    yield source.finding("shadow", node.lineno, node.id)


def _bound_names(node: ast.AST) -> Iterator[str]:
    """Yield the names that a node binds."""
    if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
        yield node.id
    elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
        yield node.attr
    elif isinstance(node, ast.arg):
        yield node.arg
    elif isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
        yield node.name
    elif isinstance(node, ast.ExceptHandler | ast.MatchAs | ast.MatchStar):
        yield node.name or ""
    elif isinstance(node, ast.MatchMapping) and node.rest is not None:
        yield node.rest
    elif isinstance(node, ast.alias) and node.asname is not None:
        yield node.asname


def _find_in_definitions(
    source: Source, parent: ast.Module | ast.ClassDef, is_module: bool
) -> Iterator[Finding]:
    for node in parent.body:
        if not isinstance(
            node, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef
        ) or node.name.startswith("_"):
            continue
        docstring = ast.get_docstring(node)
        if docstring is not None and FRAGMENT.match(docstring):
            yield source.finding("fragment", node.lineno, node.name)
        if isinstance(node, ast.ClassDef):
            yield from _find_in_definitions(source, node, is_module=False)
        elif UNSEEN & set(map(_decorator_name, node.decorator_list)):
            continue
        elif is_module and "_" not in node.name and node.name != "main":
            yield source.finding("one_word", node.lineno, node.name)
        if docstring is None:
            yield source.finding("undocumented", node.lineno, node.name)


def _decorator_name(node: ast.expr) -> str:
    function = node.func if isinstance(node, ast.Call) else node
    return function.attr if isinstance(function, ast.Attribute) else getattr(function, "id", "")


def count_findings(findings: Iterable[Finding]) -> dict[str, dict[str, float]]:
    """Return how many findings every package has of every check."""
    totals: dict[str, dict[str, float]] = {}
    for finding in sorted(findings, key=attrgetter("package", "check")):
        checks = totals.setdefault(finding.package, {})
        checks[finding.check] = checks.get(finding.check, 0) + 1
    return totals


def main() -> None:
    """Print the findings of a check."""
    parser = argparse.ArgumentParser(prog="python -m tests.support.names", description=__doc__)
    parser.add_argument("check", choices=CHECKS)
    check = parser.parse_args().check
    for finding in find_names(read_sources()):
        if finding.check == check:
            print(f"{finding.place}: {finding.name}")


if __name__ == "__main__":
    main()
