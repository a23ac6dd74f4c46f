"""Generated models, modules and sidecars, of this project, of installed packages, or in a user's
folder.

`extract_outputs` and `find_periodic` read the source of a generated function over arrays.
"""

from __future__ import annotations

import ast
import hashlib
import importlib
import importlib.util
import inspect
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cache
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path
from types import ModuleType
from typing import Any

from planter import plugins
from planter.errors import InputError
from planter.text_files import check_regular, parse_json, read_json, read_text

DERIVE_AGAIN = "run `planter derive` again on the file that states the mechanism"
MANIFEST = ".planter.json"
"""File beside derived ones with the hashes of what was written."""
MOST_BYTES = 200_000_000
"""Bytes of a generated file, and values of a sidecar: the limits of files are for what users
write.
"""


@cache
def _package() -> str:
    """Return the package of the generated code: in a wheel a part of `planter`, in a checkout a
    package next to it.
    """
    return "planter.generated" if importlib.util.find_spec("planter.generated") else "generated"


@cache
def _places() -> dict[str, Traversable]:
    """Packages of generated code with their folders: ours first."""
    package = _package()
    packages = plugins.find_packages()
    modules = {
        f"{packages[name]}.generated": place
        for name, place in plugins.find_folders("generated").items()
    }
    return {package: files(package)} | modules


@cache
def module(name: str, folder: Path | None = None) -> ModuleType:
    """Return a generated module, from `folder` if given. Raises InputError if it does not exist."""
    if folder is not None:
        return _from_file(folder.joinpath(*name.split(".")).with_suffix(".py"))
    return importlib.import_module(f"{_holder(name)}.{name}")


def text(name: str) -> str:
    """Return the text of a generated module. Raises InputError if it does not exist."""
    return _places()[_holder(name)].joinpath(f"{name}.py").read_text(encoding="utf-8")


def hash_modules(modules: Sequence[ModuleType]) -> dict[str, str]:
    """Return the SHA-256 of the sources of generated modules, by their names within their
    package.
    """
    return {
        module.__name__.rpartition("generated.")[2]: hashlib.sha256(
            inspect.getsource(module).encode()
        ).hexdigest()
        for module in modules
    }


def list_installed(modules: Iterable[str]) -> list[str]:
    """Return which modules, by their names within their package, are here."""
    installed = {f"array.{stem}" for stem in names()}
    return [name for name in modules if name in installed]


def find_changed(hashes: Mapping[str, str]) -> list[str]:
    """Return which modules, of those with the hashes of their sources by name, are here with
    another source.
    """
    loaded_modules = {name: module(name) for name in list_installed(hashes)}
    return sorted(
        name
        for name, loaded in loaded_modules.items()
        if hash_modules([loaded])[name] != hashes[name]
    )


@cache
def sidecar(name: str, folder: Path | None = None) -> dict[str, Any]:
    """Return the JSON sidecar of a generated module. Raises InputError if it does not exist."""
    if folder is not None:
        return _read_user_sidecar(folder / f"{name}.json")
    text = _places()[_holder(name)].joinpath(f"{name}.json").read_text(encoding="utf-8")
    return parse_json(text, name, MOST_BYTES, MOST_BYTES)


def names(prefix: str = "") -> list[str]:
    """Names of what was generated, sorted: all, or those that begin alike."""
    return sorted(
        {
            name
            for place in _places().values()
            for name in _sidecars(place)
            if name.startswith(prefix)
        }
    )


def _sidecars(place: Traversable) -> Iterator[str]:
    return (
        file.name.removesuffix(".json") for file in place.iterdir() if file.name.endswith(".json")
    )


def _holder(name: str) -> str:
    """The package that holds a module (of `array.NAME`, the one that holds NAME)."""
    stem = name.rpartition(".")[2]
    for package, place in _places().items():
        if place.joinpath(f"{stem}.json").is_file():
            return package
    raise InputError(f"{stem}: nothing of that name was generated (there is: {', '.join(names())})")


class _UserSidecar(dict[str, Any]):
    """An object of a user's sidecar, of which a key that is missing is one sentence wherever it is
    looked up.
    """

    place: str = ""

    def __missing__(self, key: str) -> Any:
        raise refuse_generated(self.place, f"{key} is missing")


def _read_user_sidecar(path: Path) -> dict[str, Any]:
    """Return the sidecar of a user's mechanism.

    Raises InputError for one that `planter derive` did not write.
    """

    def wrap(entry: Any, place: str) -> Any:
        if isinstance(entry, dict):
            wrapped = _UserSidecar(
                (key, wrap(value, f"{place}: {key}")) for key, value in entry.items()
            )
            wrapped.place = place
            return wrapped
        return [wrap(value, place) for value in entry] if isinstance(entry, list) else entry

    try:
        source = read_text(path, MOST_BYTES)
        content: dict[str, Any] = wrap(
            parse_json(source, str(path), MOST_BYTES, MOST_BYTES), str(path)
        )
        written = read_json(path.parent / MANIFEST) if (path.parent / MANIFEST).is_file() else {}
    except InputError as error:
        raise InputError(f"{error.message}; {DERIVE_AGAIN}") from None
    independent = written.get("independent")
    stated = independent.get(path.name) if isinstance(independent, dict) else None
    # a checkout may have other line ends
    if stated and stated != hashlib.sha256(source.replace("\r\n", "\n").encode()).hexdigest():
        raise refuse_generated(path, "it was edited since it was derived")
    vectors, functions = content["vectors"], content["functions"]
    for name, section in (("vectors", vectors), ("functions", functions)):
        if not isinstance(section, dict):
            raise refuse_generated(path, f"{name} is no object")
    for name, entries in vectors.items():
        if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
            raise refuse_generated(path, f"vectors: {name} is no list of entries")
        for entry in entries:
            if not all(isinstance(entry[key], str) for key in ("name", "unit", "meaning")):
                raise refuse_generated(path, f"vectors: {name}: a name, unit or meaning is no text")
    for name, function in functions.items():
        if not isinstance(function, dict) or not isinstance(function["output"], str):
            raise refuse_generated(path, f"functions: {name} gives nothing")
    return content


def check_user_model(name: str, folder: Path) -> None:
    """Raise InputError unless a folder holds the sidecar of a user's mechanism, and modules with
    its functions.
    """
    needed = sidecar(name, folder)["functions"].keys()
    for path in (folder / f"{name}.py", folder / "array" / f"{name}.py") if needed else ():
        if not path.is_file():
            raise refuse_generated(path, "there is no such file")
        try:
            source = read_text(path, MOST_BYTES)
        except InputError as error:
            raise InputError(f"{error.message}; {DERIVE_AGAIN}") from None
        lacking = needed - set(re.findall(r"^def (\w+)\(", source, re.MULTILINE))
        if lacking:
            raise refuse_generated(path, f"the function {sorted(lacking)[0]} is missing")


def refuse_generated(path: str | Path, problem: str) -> InputError:
    """Return the error of a generated file that is not as `planter derive` wrote it."""
    return InputError(f"{path}: {problem}; {DERIVE_AGAIN}")


def _from_file(path: Path) -> ModuleType:
    check_regular(path)
    spec = importlib.util.spec_from_file_location(f"generated_{path.stem}", path)
    if spec is None or spec.loader is None:
        raise InputError(f"{path}: this is no Python file")
    loaded = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(loaded)
    except Exception as error:  # of whatever kind: the file may hold anything
        raise refuse_generated(path, f"it does not run: {type(error).__name__}: {error}") from None
    return loaded


def extract_outputs(
    module: ModuleType, stage: str, outputs: Sequence[int], bindings: Mapping[str, Any]
) -> Callable[..., tuple[Any, ...]]:
    """Return a straight-line function of a generated module that yields some of its outputs, by
    their indices.

    `bindings` are values of variables, which are not computed then, and functions that replace
    those of the module.
    """
    tree = ast.parse(inspect.getsource(getattr(module, stage)))
    (function,) = tree.body
    assert isinstance(function, ast.FunctionDef)
    end = function.body[-1]
    assert isinstance(end, ast.Return)
    assert isinstance(end.value, ast.Tuple)
    end.value.elts = [end.value.elts[index] for index in outputs]
    body: list[ast.stmt] = [end]
    needed = _find_names(end) - set(bindings)
    for statement in reversed(function.body[:-1]):
        if isinstance(statement, ast.Assign) and needed & _find_names(statement.targets[0]):
            body.append(statement)
            needed |= _find_names(statement.value) - set(bindings)
    function.body = body[::-1]
    namespace = {**vars(module), **bindings}
    exec(compile(tree, f"{module.__file__}, cut down", "exec"), namespace)
    result: Callable[..., tuple[Any, ...]] = namespace[stage]
    return result


def find_periodic(module: ModuleType, stage: str, argument: str, size: int) -> list[bool]:
    """Return of which entries (size,) of an argument a function takes nothing but sine and
    cosine.
    """
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
        if (
            isinstance(node, ast.Name)
            and isinstance(node.ctx, ast.Load)
            and node.id in names
            and id(node) not in taken
        ):
            unsafe.add(names[node.id])
    return [index in names.values() and index not in unsafe for index in range(size)]


def _find_names(node: ast.AST) -> set[str]:
    return {part.id for part in ast.walk(node) if isinstance(part, ast.Name)}
