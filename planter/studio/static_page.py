"""The studio's page of a machine as one HTML file with programs in WebAssembly:
`planter studio --static`.

The page loads no external resources. Its content security policy allows its script and style by
their hashes; 'wasm-unsafe-eval' lets the script compile the programs.
"""

from __future__ import annotations

import base64
import difflib
import gzip
import json
import re
from collections.abc import Mapping, Sequence
from importlib import resources
from pathlib import Path
from string import Template
from typing import Any

from planter.errors import ComputationError, InputError
from planter.kernels.compiler import CompilerError
from planter.kernels.lane_graph import NotPrintableError
from planter.kernels.programs import build_webassembly
from planter.report.files import write_bytes
from planter.report.folder import check_files
from planter.report.html import escape_markup, policy_source
from planter.report.subject import Control, Movable, Searching, open_machine
from planter.studio.static_model import StaticPageModel
from planter.version import __version__

MODULES = ("programs", "filled", "improve", "text", "line")
"""JavaScript modules of this package, each after those that it imports from."""
HOLE = "{}"
"""Placeholder of a moved number in a line of a file."""
SHARE = 0.381966011250105
"""Share of the way to a bound at which a number is tried, so that its digits occur nowhere else in
the file.
"""
_IMPORT = re.compile(r'^import (\{[^}]*\}) from "\./(\w+)\.js";$', re.MULTILINE)
_NAMED = re.compile(r"^export ((?:async )?(?:class|function|const) (\w+))", re.MULTILINE)
_DEFAULT = re.compile(r"^export default .*$", re.MULTILINE)


def write_page(source: str, file: Path) -> Path:
    """Write the page of a machine, a file or built-in name, to an HTML file, and return its path.

    Raises InputError if the file does not end in .html, if no page can compute the machine, or if
    the compiler is missing.
    """
    if file.suffix.lower() != ".html":
        raise InputError(f"--static {file}: the page is HTML; name a file that ends in .html")
    check_files(file.parent, [file.name])
    machine = open_machine(source)
    if not isinstance(machine, Movable):
        raise InputError(
            f"--static is not available for {source}: such a machine is computed in Python only"
        )
    try:
        text = build_page(machine)
    except NotPrintableError as reason:
        raise InputError(f"--static is not available for {source}: {reason}") from None
    except CompilerError as reason:
        raise InputError(f"--static {file} cannot be written: {reason}") from None
    write_bytes(file, text.encode())
    return file


def build_page(machine: Movable) -> str:
    """Return the page.

    Raises CompilerError if the programs cannot be compiled, and the errors of these programs.
    """
    rigid = machine.rigid
    models = {name: StaticPageModel(rigid, name) for name in machine.models}
    programs = [program for model in models.values() for program in model.portable.programs]
    module = gzip.compress(build_webassembly(programs), mtime=0)
    description = {
        "name": machine.name,
        "controls": [control.to_json() for control in rigid.controls],
        "goal": machine.describe_goal() if isinstance(machine, Searching) else "",
        "search": "Improve" if all(model.portable.gradient for model in models.values()) else None,
        "models": {name: model.json() for name, model in models.items()},
        "programs": {program.name: program.size for program in programs},
        "module": base64.b64encode(module).decode("ascii"),
        "file": file_template(machine, rigid.controls),
    }
    return _html(machine, description, models)


def _html(
    machine: Movable, description: Mapping[str, Any], models: Mapping[str, StaticPageModel]
) -> str:
    studio, view = "planter.studio", "planter.report"
    modules = {
        "view": _text(view, "view.js"),
        **{name: _text(studio, f"{name}.js") for name in ("tables", "fields", "exports")},
        **{name: _text(studio, f"static/{name}.js") for name in MODULES},
        "studio": _text(studio, "studio.js"),
    }
    script, style = (
        bundle_modules(modules),
        "\n".join([_text(view, "view.css"), _text(studio, "studio.css")]),
    )
    policy = (
        f"default-src 'none'; script-src {policy_source(script)} 'wasm-unsafe-eval'; style-src "
        f"{policy_source(style)}; "
        "img-src data:; base-uri 'none'; form-action 'none'"
    )
    body = _text(studio, "studio.html").partition("<body>")[2].partition("</body>")[0]
    notes = (note for model in models.values() for note in model.portable.notes)
    return Template(_text(studio, "static/page.html")).substitute(
        policy=policy,
        name=escape_markup(machine.name),
        style=style,
        script=script,
        body=body.strip(),
        machine=json.dumps(description, separators=(",", ":")).replace("<", "\\u003c"),
        version=__version__,
        notes=escape_markup(" ".join(dict.fromkeys(notes))),
        assumptions="".join(
            f"<h3>{name}</h3><p>{escape_markup('; '.join(model.portable.assumptions))}.</p>"
            for name, model in models.items()
        ),
    )


def _text(package: str, name: str) -> str:
    return resources.files(package).joinpath(name).read_text(encoding="utf-8")


def bundle_modules(modules: Mapping[str, str]) -> str:
    """Return ES modules as one script; `modules` are texts by name, each after those that it
    imports from.
    """
    return "\n".join(
        ["const modules = {};", *(_scoped(name, text) for name, text in modules.items())]
    )


def _scoped(name: str, text: str) -> str:
    exported = ", ".join(export for _, export in _NAMED.findall(text))
    inner = _IMPORT.sub(r"const \1 = modules.\2;", _DEFAULT.sub("", _NAMED.sub(r"\1", text)))
    return f"modules.{name} = (() => {{\n{inner}\nreturn {{ {exported} }};\n}})();"


def file_template(machine: Movable, controls: Sequence[Control]) -> dict[str, Any]:
    """Return the lines of a machine's file, and edits by path of controls, which replace the lines
    `from` to `to`.

    Raises ComputationError if two numbers are in the same line.
    """
    values = {control.path: control.value for control in controls}
    lines = machine.handed(values).splitlines()
    edits = {control.path: _edits(machine, values, lines, control) for control in controls}
    replaced = [
        line
        for changes in edits.values()
        for edit in changes
        for line in range(edit["from"], edit["to"])
    ]
    if len(set(replaced)) < len(replaced):
        raise ComputationError(
            f"{machine.name}: a page without a server cannot write its file, line by line"
        )
    return {"lines": lines, "edits": edits}


def _edits(
    machine: Movable, values: dict[str, float], lines: list[str], control: Control
) -> list[dict[str, Any]]:
    bound = control.upper if control.upper > control.value else control.lower
    trial = control.value + SHARE * (bound - control.value)
    moved = machine.handed(values | {control.path: trial}).splitlines()
    return [
        {"from": i, "to": j, "lines": [line.replace(repr(trial), HOLE) for line in moved[k:m]]}
        for kind, i, j, k, m in difflib.SequenceMatcher(
            None, lines, moved, autojunk=False
        ).get_opcodes()
        if kind != "equal"
    ]
