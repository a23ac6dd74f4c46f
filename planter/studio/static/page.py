"""The studio's page of a machine as one HTML file: its programs in WebAssembly, nothing fetched, nothing else run.

The content security policy names the one script and the one style by their hashes; 'wasm-unsafe-eval' lets the script
compile the programs.
"""

from __future__ import annotations

import base64
import gzip
import json
from collections.abc import Mapping
from importlib import resources
from string import Template
from typing import Any

from planter.kernels.programs import webassembly
from planter.report.html import allowed, escape
from planter.studio.static import written
from planter.studio.static.bundle import bundle
from planter.studio.static.model import Model
from planter.version import __version__
from planter.view.portable import Movable

OWN = ("programs", "filled", "improve", "text", "line")
"""Modules of this room, each after those that it imports from."""


def page(machine: Movable) -> str:
    """The page. Raises NoCompiler where the programs cannot be compiled, and what the machine's programs raise."""
    models = {name: Model(machine, name) for name in machine.models}
    programs = [program for model in models.values() for program in model.portable.programs]
    module = gzip.compress(webassembly.module(programs), mtime=0)
    told = {
        "name": machine.name,
        "controls": [one.to_json() for one in machine.controls],
        "search": "Improve" if all(model.portable.gradient for model in models.values()) else None,
        "models": {name: model.json() for name, model in models.items()},
        "programs": {program.name: program.size for program in programs},
        "module": base64.b64encode(module).decode("ascii"),
        "file": written.template(machine),
    }
    return _html(machine, told, models)


def _html(machine: Movable, told: Mapping[str, Any], models: Mapping[str, Model]) -> str:
    studio, view, own = "planter.studio", "planter.view", __package__
    modules = {
        "view": _text(view, "view.js"),
        "exports": _text(studio, "exports.js"),
        **{name: _text(own, f"{name}.js") for name in OWN},
        "studio": _text(studio, "studio.js"),
    }
    script, style = bundle(modules), "\n".join([_text(view, "view.css"), _text(studio, "studio.css")])
    policy = (
        f"default-src 'none'; script-src {allowed(script)} 'wasm-unsafe-eval'; style-src {allowed(style)}; "
        "img-src data:; base-uri 'none'; form-action 'none'"
    )
    body = _text(studio, "studio.html").partition("<body>")[2].partition("</body>")[0]
    return Template(_text(own, "page.html")).substitute(
        policy=policy, name=escape(machine.name), style=style, script=script, body=body.strip(),
        machine=json.dumps(told, separators=(",", ":")).replace("<", "\\u003c"), version=__version__,
        notes=escape(" ".join(dict.fromkeys(note for model in models.values() for note in model.portable.notes))),
        assumptions="".join(f"<h3>{name}</h3><p>{escape('; '.join(model.portable.assumptions))}.</p>"
                            for name, model in models.items()),
    )  # fmt: skip


def _text(package: str | None, name: str) -> str:
    assert package is not None
    return resources.files(package).joinpath(name).read_text(encoding="utf-8")
