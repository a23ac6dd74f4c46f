"""Messages of validation errors: file, key, value, and the allowed values."""

from collections.abc import Collection, Sequence
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails, InitErrorDetails, PydanticCustomError

from planter import safe_text
from planter.errors import InputError
from planter.files import paths, schema, units

_ALLOWED: dict[str, str] = {
    "bool_type": "it must be true or false",
    "dict_type": "it must be a table",
    "finite_number": "it must be a finite number",
    "float_type": "it must be a number",
    "greater_than": "it must be greater than {gt:g}",
    "greater_than_equal": "it must be at least {ge:g}",
    "int_from_float": "it must be a whole number",
    "int_type": "it must be a whole number",
    "less_than": "it must be less than {lt:g}",
    "less_than_equal": "it must be at most {le:g}",
    "list_type": "it must be a list",
    "literal_error": "it must be {expected}",
    "model_type": "it must be a table",
    "refused": "{allowed}",
    "string_too_long": "it must have at most {max_length} characters",
    "string_too_short": "it must not be empty",
    "string_type": "it must be text in quotes",
    "too_long": "it must have at most {max_length} entries",
    "too_short": "it must have at least {min_length} entries",
    "tuple_type": "it must be a list",
}
_OTHERWISE = "it must be a value of another kind"
_LISTED = 8
"""Maximum number of problems in a message."""
SET = "set on the command line"


def refused(key: str, value: object, allowed: str) -> PydanticCustomError:
    """Return the error of a validator for an invalid value at `key`, relative to the table of the validator.

    `allowed` continues the sentence "... is not allowed: ", so it reads "it must ...".
    """
    return PydanticCustomError("refused", "{allowed}", {"key": key, "value": value, "allowed": allowed})


def lacking(key: str, allowed: str) -> PydanticCustomError:
    """Return the error of a validator for a missing key that another part of the file requires."""
    return PydanticCustomError("refused", "{allowed}", {"key": key, "allowed": allowed})


def refuse(problems: Sequence[PydanticCustomError]) -> None:
    """Raise all problems of a validator together, if any."""
    if problems:
        raise ValidationError.from_exception_data("", [InitErrorDetails(type=error, input=None) for error in problems])


def not_allowed(source: str, path: str, value: object, allowed: str, *, changed: bool = False) -> str:
    """Return the message for an invalid value.

    >>> not_allowed("my.toml", "mass.sun_kg", -0.4, "it must be greater than 0")
    'my.toml: mass.sun_kg = -0.4 is not allowed: it must be greater than 0'
    """
    return f"{source}: {problem(path, value, allowed, changed)}"


def explain(error: ValidationError, source: str, model: type[BaseModel], changed: Collection[str] = ()) -> InputError:
    """Return an error with the problems of `source` that pydantic reports, at most 8, and the number of the others.

    Unknown keys come first, since a misspelt key usually explains a missing one. The message marks values whose path is
    in `changed` as set on the command line.
    """
    errors = sorted(error.errors(include_url=False), key=lambda details: details["type"] != "extra_forbidden")
    problems = "; ".join(_problem(details, model, changed) for details in errors[:_LISTED])
    more = len(errors) - _LISTED
    tail = f" (and {more} more problem{'s' if more > 1 else ''})" if more > 0 else ""
    return InputError(f"{source}: {problems}{tail}")


def problem(path: str, value: object, allowed: str, changed: bool = False) -> str:
    """Return the message for an invalid value, without its file."""
    note = f" ({SET})" if changed else ""
    return f"{safe_text.quote_name(path)} = {safe_text.format_value(value)}{note} is not allowed: {allowed}"


def _problem(details: ErrorDetails, model: type[BaseModel], changed: Collection[str]) -> str:
    context: dict[str, Any] = details.get("ctx", {})
    location = (*details["loc"], context["key"]) if context.get("key") else details["loc"]
    path = paths.join(location)
    if details["type"] == "missing":
        return f"{safe_text.quote_name(path)} is missing: it must be given{_in_unit(path)}"
    if details["type"] == "refused" and "value" not in context:
        return f"{safe_text.quote_name(path)} is missing: {context['allowed']}"
    value = context.get("value", details["input"])
    if details["type"] == "extra_forbidden":
        allowed = _known_keys(model, location)
    else:
        allowed = _ALLOWED.get(details["type"], _OTHERWISE).format(**context)
    if details["type"] in ("float_type", "int_type") and isinstance(value, str):
        pointed = safe_text.replace_decimal_comma(value)
        allowed += f" without quotes, with a decimal point: {pointed}" if pointed else ", without quotes"
    set_here = any(name == path or name.startswith(f"{path}[") for name in changed)
    return problem(path, value, allowed, set_here)


def _in_unit(path: str) -> str:
    unit = units.unit(path)
    return f", in {unit}" if unit else ""


def _known_keys(model: type[BaseModel], location: tuple[str | int, ...]) -> str:
    *inner, unknown = location
    table = schema.section(schema.annotation(model, tuple(inner)))
    keys = list(schema.fields(table)) if table else []
    similar = paths.close(str(unknown), keys)
    hint = f": did you mean {similar[0]}?" if similar else ""
    allowed = f" (allowed here: {', '.join(keys)})" if keys else ""
    return f"there is no such key{hint}{allowed}"
