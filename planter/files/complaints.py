"""What pydantic finds wrong with a file, as one plain sentence: file, key, value given, what is allowed."""

import json
import math
from collections.abc import Collection
from typing import Any, get_args

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails, PydanticCustomError

from planter.errors import InputError
from planter.files import paths, units

_ALLOWED: dict[str, str] = {
    "dict_type": "it must be a table",
    "finite_number": "it must be a finite number",
    "float_type": "it must be a number",
    "greater_than": "it must be greater than {gt:g}",
    "greater_than_equal": "it must be at least {ge:g}",
    "int_from_float": "it must be a whole number",
    "int_type": "it must be a whole number",
    "less_than": "it must be less than {lt:g}",
    "less_than_equal": "it must be at most {le:g}",
    "literal_error": "it must be {expected}",
    "model_type": "it must be a table",
    "refused": "{allowed}",
    "string_too_long": "it must have at most {max_length} characters",
    "string_too_short": "it must not be empty",
    "string_type": "it must be text in quotes",
    "too_short": "it must not be empty",
}
_SHOWN_AT_MOST = 60
SET = "set on the command line"


def refused(key: str, value: object, allowed: str) -> PydanticCustomError:
    """The error for a validator to raise on the value at `key`, relative to where the validator stands.

    `allowed` continues the sentence "... is not allowed: ", so it reads "it must ...".
    """
    return PydanticCustomError("refused", "{allowed}", {"key": key, "value": value, "allowed": allowed})


def lacking(key: str, allowed: str) -> PydanticCustomError:
    """The error for a validator to raise when a key is missing that another part of the file calls for."""
    return PydanticCustomError("refused", "{allowed}", {"key": key, "allowed": allowed})


def not_allowed(source: str, path: str, value: object, allowed: str, *, overridden: bool = False) -> str:
    """The sentence for a value that cannot be used.

    >>> not_allowed("my.toml", "mass.sun_kg", -0.4, "it must be greater than 0")
    'my.toml: mass.sun_kg = -0.4 is not allowed: it must be greater than 0'
    """
    note = f" ({SET})" if overridden else ""
    return f"{source}: {_printable(path)} = {shown(value)}{note} is not allowed: {allowed}"


def explain(
    error: ValidationError, source: str, model: type[BaseModel], overridden: Collection[str] = ()
) -> InputError:
    """One sentence for the first error that pydantic found in `source`, and how many more there are.

    An unknown key comes first: a misspelt one is usually also the reason why another is missing. A value
    whose path is in `overridden` is said to come from the command line.
    """
    errors = sorted(error.errors(include_url=False), key=lambda found: found["type"] != "extra_forbidden")
    more = len(errors) - 1
    tail = f" (and {more} more problem{'s' if more > 1 else ''})" if more else ""
    return InputError(_sentence(errors[0], source, model, overridden) + tail)


def _sentence(found: ErrorDetails, source: str, model: type[BaseModel], overridden: Collection[str]) -> str:
    context: dict[str, Any] = found.get("ctx", {})
    location = (*found["loc"], context["key"]) if context.get("key") else found["loc"]
    path = paths.join(location)
    if found["type"] == "missing":
        return f"{source}: {path} is missing: it must be given{_in_unit(path)}"
    if found["type"] == "refused" and "value" not in context:
        return f"{source}: {path} is missing: {context['allowed']}"
    if found["type"] == "extra_forbidden":
        allowed = _known_keys(model, location)
    else:
        allowed = _ALLOWED[found["type"]].format(**context) if found["type"] in _ALLOWED else found["msg"]
    given = context.get("value", found["input"])
    set_here = any(name == path or name.startswith(f"{path}[") for name in overridden)
    return not_allowed(source, path, given, allowed, overridden=set_here)


def _in_unit(path: str) -> str:
    unit = units.unit(path)
    return f", in {unit}" if unit else ""


def _known_keys(model: type[BaseModel], location: tuple[str | int, ...]) -> str:
    *inner, unknown = location
    for part in (part for part in inner if isinstance(part, str)):
        annotation = model.model_fields[part].annotation
        tables = [kind for kind in (annotation, *get_args(annotation)) if isinstance(kind, type)]
        model = next(kind for kind in tables if issubclass(kind, BaseModel))
    known = [field.alias or name for name, field in model.model_fields.items()]
    similar = paths.close(str(unknown), known)
    hint = f"did you mean {similar[0]}? " if similar else ""
    return f"there is no such key, {hint}(allowed here: {', '.join(known)})"


def shown(value: object) -> str:
    """A value as a TOML file would show it, shortened to one line of reasonable length."""
    infinite = isinstance(value, float) and not math.isfinite(value)
    text = str(value) if infinite else json.dumps(value, default=str)
    return text if len(text) <= _SHOWN_AT_MOST else text[:_SHOWN_AT_MOST] + "..."


def _printable(path: str) -> str:
    return path if path.isprintable() else json.dumps(path)
