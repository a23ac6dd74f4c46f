"""ES modules as one script: each in a scope of its own, imports by the names of their files."""

from __future__ import annotations

import re
from collections.abc import Mapping

_IMPORT = re.compile(r'^import (\{[^}]*\}) from "\./(\w+)\.js";$', re.MULTILINE)
_NAMED = re.compile(r"^export ((?:async )?(?:class|function|const) (\w+))", re.MULTILINE)
_DEFAULT = re.compile(r"^export default .*$", re.MULTILINE)


def bundle(modules: Mapping[str, str]) -> str:
    """The script, from texts by name in an order in which each imports from those before it alone."""
    return "\n".join(["const modules = {};", *(_scoped(name, text) for name, text in modules.items())])


def _scoped(name: str, text: str) -> str:
    exported = ", ".join(found for _, found in _NAMED.findall(text))
    inner = _IMPORT.sub(r"const \1 = modules.\2;", _DEFAULT.sub("", _NAMED.sub(r"\1", text)))
    return f"modules.{name} = (() => {{\n{inner}\nreturn {{ {exported} }};\n}})();"
