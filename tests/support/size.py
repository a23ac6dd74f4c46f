"""`python -m tests.support.size` compares size and names of the code with the committed totals.

Totals may only fall. The command lowers those in tests/size.toml to those of today, unless one has
risen; `--check` writes nothing. Of `planter`, `derive` and `tests` it counts

* tokens: of code, without comments, docstrings and line ends;
* tokens_per_line: of lines of code, to one decimal;
* long_lines: of code, over 100 characters;
* comprehensions;
* crowded: comprehensions after the first of a statement, and assignments within one;
* public_classes.

Findings of names (`tests.support.names`) are counted package by package.
"""

from __future__ import annotations

import argparse
import ast
import gc
import io
import sys
import tokenize
import tomllib
from collections import Counter
from collections.abc import Iterable, Mapping

from tests.support.names import Source, count_findings, find_names, read_sources
from tests.support.structure import ROOT

TOTALS = ROOT / "tests" / "size.toml"
LONGEST_LINE = 100
LAYOUT = {
    tokenize.COMMENT,
    tokenize.NL,
    tokenize.NEWLINE,
    tokenize.INDENT,
    tokenize.DEDENT,
    tokenize.ENDMARKER,
}
COMPREHENSIONS = ast.ListComp | ast.SetComp | ast.DictComp | ast.GeneratorExp

Totals = Mapping[str, Mapping[str, float]]


def measure_source(source: Source) -> Counter[str]:
    """Return the counts of a module, and its lines of code."""
    counts, docstrings = _count_syntax(source.tree)
    lines: set[int] = set()
    for token in tokenize.generate_tokens(io.StringIO(source.text).readline):
        if token.type not in LAYOUT and token.start[0] not in docstrings:
            lines.update(range(token.start[0], token.end[0] + 1))
            counts["tokens"] += 1
    rows = source.text.splitlines()
    counts["lines"] = len(lines)
    counts["long_lines"] = sum(len(rows[line - 1]) > LONGEST_LINE for line in lines)
    return counts


def _count_syntax(tree: ast.Module) -> tuple[Counter[str], set[int]]:
    """Return the counts of a tree, and the lines of strings that are statements of their own."""
    counts: Counter[str] = Counter()
    comprehensions: Counter[ast.AST] = Counter()
    docstrings: set[int] = set()
    stack: list[tuple[ast.AST, ast.AST, bool]] = [(tree, tree, False)]
    while stack:
        node, statement, is_inside = stack.pop()
        if isinstance(node, ast.stmt):
            statement = node
        if isinstance(node, ast.ClassDef):
            counts["public_classes"] += not node.name.startswith("_")
        elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            docstrings.update(range(node.lineno, (node.end_lineno or 0) + 1))
        elif isinstance(node, COMPREHENSIONS):
            comprehensions[statement] += 1
            is_inside = True
        elif isinstance(node, ast.NamedExpr):
            counts["crowded"] += is_inside
        stack += [(child, statement, is_inside) for child in ast.iter_child_nodes(node)]
    counts["comprehensions"] = comprehensions.total()
    counts["crowded"] += comprehensions.total() - len(comprehensions)
    return counts, docstrings


def measure_sources(sources: Iterable[Source]) -> dict[str, dict[str, float]]:
    """Return the totals of each root package."""
    counts: dict[str, Counter[str]] = {}
    for source in sources:
        counts.setdefault(source.path.partition("/")[0], Counter()).update(measure_source(source))
    totals: dict[str, dict[str, float]] = {}
    for package, count in counts.items():
        lines = count.pop("lines")
        ratio = round(count["tokens"] / max(lines, 1), 1)
        totals[package] = {**count, "tokens_per_line": ratio}
    return totals


def measure_repository() -> dict[str, dict[str, float]]:
    """Return the totals of this project: sizes of its packages, then names of their parts."""
    gc.disable()  # it takes 60 % of the time otherwise
    try:
        sources = list(read_sources())
        totals = measure_sources(sources)
        for package, checks in count_findings(find_names(sources)).items():
            totals[package] = totals.get(package, {}) | checks
        return totals
    finally:
        gc.enable()


def find_rises(before: Totals, after: Totals) -> dict[str, tuple[float, float]]:
    """Return the totals that have risen, as `package check`, with their values before and after."""
    rises: dict[str, tuple[float, float]] = {}
    for package, checks in after.items():
        for check, count in checks.items():
            limit = before.get(package, {}).get(check, 0)
            if count > limit:
                rises[f"{package} {check}"] = (limit, count)
    return rises


def read_totals() -> dict[str, dict[str, float]]:
    """Return the committed totals."""
    return tomllib.loads(TOTALS.read_text(encoding="utf-8"))


def write_totals(totals: Totals) -> None:
    """Write totals as a table for each package."""
    lines: list[str] = []
    for package, checks in totals.items():
        lines += [f'["{package}"]', *(f"{check} = {count}" for check, count in checks.items()), ""]
    TOTALS.write_text("\n".join(lines), encoding="utf-8")


def main() -> int:
    """Run the command line; return the exit code."""
    parser = argparse.ArgumentParser(prog="python -m tests.support.size", description=__doc__)
    parser.add_argument("--check", action="store_true", help="write no lower totals")
    options = parser.parse_args()
    totals = measure_repository()
    rises = find_rises(read_totals(), totals)
    for place, (before, after) in rises.items():
        print(f"{place}: {after}, at most {before} are allowed", file=sys.stderr)
    if not rises and not options.check:
        write_totals(totals)
    return int(bool(rises))


if __name__ == "__main__":
    sys.exit(main())
