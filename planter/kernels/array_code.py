"""Functions of generated array code, cut down to the outputs that are needed."""

from __future__ import annotations

import ast
import inspect
from collections.abc import Callable, Mapping, Sequence
from types import ModuleType
from typing import Any


def extract_outputs(
    module: ModuleType, stage: str, outputs: Sequence[int], known: Mapping[str, Any]
) -> Callable[..., tuple[Any, ...]]:
    """Return a straight-line function of a generated module that yields some of its outputs, by their indices.

    `known` are values of variables, which are not computed then, and functions that replace those of the module.
    """
    tree = ast.parse(inspect.getsource(getattr(module, stage)))
    (function,) = tree.body
    assert isinstance(function, ast.FunctionDef)
    end = function.body[-1]
    assert isinstance(end, ast.Return)
    assert isinstance(end.value, ast.Tuple)
    end.value.elts = [end.value.elts[index] for index in outputs]
    body: list[ast.stmt] = [end]
    needed = _find_names(end) - set(known)
    for statement in reversed(function.body[:-1]):
        if isinstance(statement, ast.Assign) and needed & _find_names(statement.targets[0]):
            body.append(statement)
            needed |= _find_names(statement.value) - set(known)
    function.body = body[::-1]
    namespace = {**vars(module), **known}
    exec(compile(tree, f"{module.__file__}, cut down", "exec"), namespace)
    result: Callable[..., tuple[Any, ...]] = namespace[stage]
    return result


def find_periodic(module: ModuleType, stage: str, argument: str, size: int) -> list[bool]:
    """Return of which entries (size,) of an argument a function takes nothing but sine and cosine."""
    (function,) = ast.parse(inspect.getsource(getattr(module, stage))).body
    names, unsafe = dict[str, int](), set[int]()
    for node in ast.walk(function):
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.Subscript):
            index = node.value.slice
            if isinstance(node.value.value, ast.Name) and node.value.value.id == argument:
                names[ast.unparse(node.targets[0])] = int(ast.unparse(index))
    waves = {"xp.sin", "xp.cos"}
    taken = {
        id(node.args[0])
        for node in ast.walk(function)
        if isinstance(node, ast.Call) and ast.unparse(node.func) in waves
    }
    for node in ast.walk(function):
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load) and node.id in names and id(node) not in taken:
            unsafe.add(names[node.id])
    return [index in names.values() and index not in unsafe for index in range(size)]


def _find_names(node: ast.AST) -> set[str]:
    return {part.id for part in ast.walk(node) if isinstance(part, ast.Name)}
