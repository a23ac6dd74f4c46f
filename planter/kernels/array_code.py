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


def _find_names(node: ast.AST) -> set[str]:
    return {part.id for part in ast.walk(node) if isinstance(part, ast.Name)}
