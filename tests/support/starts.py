"""Where a source starts a process: by the names of the standard library's functions, imported or as
attributes.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator

CALLS = {
    "subprocess": {
        "Popen",
        "run",
        "call",
        "check_call",
        "check_output",
        "getoutput",
        "getstatusoutput",
    },
    "os": {"system", "popen", "fork", "forkpty", "startfile"},
    "asyncio": {"create_subprocess_exec", "create_subprocess_shell"},
    "sys": {"executable"},
}
"""Functions that start a process, and the interpreter's place, by module."""
FAMILIES = ("exec", "spawn", "posix_spawn")
"""Beginnings of the names of functions of `os` that do."""
MODULES = {"multiprocessing", "pty", "_posixsubprocess", "_winapi"}
"""Modules that exist to start processes."""
ANYWHERE = {"ProcessPoolExecutor", "subprocess_exec", "subprocess_shell", *CALLS["asyncio"]}
"""Names that start processes, whatever they belong to."""


def find_starts(source: str) -> Iterator[tuple[int, str]]:
    """Yield line and name of whatever can start a process; a type in an annotation does not."""
    tree = ast.parse(source)
    types = {
        id(inner)
        for node in ast.walk(tree)
        for note in _annotations(node)
        for inner in ast.walk(note)
    }
    modules = dict(_modules(tree))
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names = [(alias.name.partition(".")[0], "") for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            names = [(str(node.module).partition(".")[0], alias.name) for alias in node.names]
        elif isinstance(node, ast.Attribute) and id(node) not in types:
            owner = modules.get(node.value.id, "") if isinstance(node.value, ast.Name) else ""
            names = [(owner, node.attr)]
        else:
            continue
        yield from (
            (node.lineno, f"{module}.{name}".strip("."))
            for module, name in names
            if _starts(module, name)
        )


def _starts(module: str, name: str) -> bool:
    if module in MODULES or name in ANYWHERE:
        return True
    return name in CALLS.get(module, ()) or (module == "os" and name.startswith(FAMILIES))


def _modules(tree: ast.AST) -> Iterator[tuple[str, str]]:
    """Names that modules have in a source."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (
                (alias.asname or alias.name.partition(".")[0], alias.name) for alias in node.names
            )


def _annotations(node: ast.AST) -> Iterator[ast.expr]:
    for name in ("annotation", "returns"):
        if isinstance(note := getattr(node, name, None), ast.expr):
            yield note
