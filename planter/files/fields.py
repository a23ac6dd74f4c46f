"""What a file's class says of its tables: the kind of the value at a place, the values that a file
may leave out.
"""

import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from functools import cache
from typing import Annotated, Any, Self, get_args, get_origin

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    ValidationError,
    model_validator,
)
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails, InitErrorDetails, PydanticCustomError

from planter import paths, safe_text
from planter.errors import InputError
from planter.files import units
from planter.paths import Location


def find_annotation(model: type[BaseModel], location: Location) -> Any:
    """Return the type of the value at a location, for items that of their list; None for an unknown
    location.
    """
    kind: Any = model
    for part in location:
        if isinstance(part, str) and get_origin(kind) is dict:
            kind = get_args(kind)[1]
        elif isinstance(part, str):
            table = find_section(kind)
            field = list_fields(table).get(part) if table else None
            kind = field.annotation if field else None
    return kind


def find_section(kind: Any) -> type[BaseModel] | None:
    """Return the class of a table in a type such as `Section`, `Section | None` or
    `list[Section]`.
    """
    if isinstance(kind, type) and issubclass(kind, BaseModel):
        return kind
    inner = () if get_origin(kind) is dict else get_args(kind)
    return next(filter(None, map(find_section, inner)), None)


def list_fields(model: type[BaseModel]) -> dict[str, FieldInfo]:
    """Return the fields of a table by their keys in a file."""
    return {field.alias or name: field for name, field in model.model_fields.items()}


def fill_defaults(model: type[BaseModel], table: Mapping[str, Any]) -> dict[str, Any]:
    """Return a table with the default values of missing keys."""
    values = dict(table)
    for key, field in list_fields(model).items():
        inner = find_section(field.annotation)
        if key not in table:
            value = None if field.is_required() else field.get_default(call_default_factory=True)
            if isinstance(value, BaseModel):
                value = value.model_dump(mode="json", by_alias=True, exclude_none=True)
            if value is not None:
                values[key] = value
        elif inner is not None and isinstance(table[key], dict):
            values[key] = fill_defaults(inner, table[key])
    return values


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
OWN = "this file"
"""Origin of a number that differs from the one that the entry in [origin] was written for."""


def invalid_value_problem(key: str, value: object, allowed: str) -> PydanticCustomError:
    """Return the error of a validator for an invalid value at `key`, relative to the table of the
    validator.

    `allowed` is the rule that the value violates: "it must ...".
    """
    return PydanticCustomError(
        "refused", "{allowed}", {"key": key, "value": value, "allowed": allowed}
    )


def missing_value_problem(key: str, allowed: str) -> PydanticCustomError:
    """Return the error of a validator for a missing key that another part of the file requires."""
    return PydanticCustomError("refused", "{allowed}", {"key": key, "allowed": allowed})


def raise_problems(problems: Sequence[PydanticCustomError]) -> None:
    """Raise all problems of a validator together, if any."""
    if problems:
        raise ValidationError.from_exception_data(
            "", [InitErrorDetails(type=error, input=None) for error in problems]
        )


def describe_problems(
    error: ValidationError, source: str, model: type[BaseModel], changed: Collection[str] = ()
) -> InputError:
    """Return an error with the problems of `source` that pydantic reports, at most 8, and the
    number of the others.

    Unknown keys come first, since a misspelt key usually explains a missing one, and those of one
    table are followed by its keys once. The message marks
    values whose path is in `changed` as set on the command line.
    """
    errors = sorted(
        error.errors(include_url=False), key=lambda details: details["type"] != "extra_forbidden"
    )
    listed: set[str] = set()
    problems = "; ".join(_problem(details, model, changed, listed) for details in errors[:_LISTED])
    more = len(errors) - _LISTED
    tail = f" (and {more} more problem{'s' if more > 1 else ''})" if more > 0 else ""
    return InputError(f"{source}: {problems}{tail}")


def value_error(
    path: str, value: object, rule: str, source: str = "", *, is_changed: bool = False
) -> InputError:
    """Return the error of an invalid value of a file, written as in TOML, and marked if the command
    line set it.
    """
    text = f"{safe_text.format_value(value)}{f' ({SET})' if is_changed else ''}"
    return InputError.for_value(safe_text.quote_name(path), text, rule, source)


def _problem(
    details: ErrorDetails, model: type[BaseModel], changed: Collection[str], listed: set[str]
) -> str:
    context: dict[str, Any] = details.get("ctx", {})
    location = (*details["loc"], context["key"]) if context.get("key") else details["loc"]
    path = paths.join_location(location)
    if details["type"] == "missing":
        unit = units.display_unit(path)
        in_unit = f", in {unit}" if unit else ""
        return f"{safe_text.quote_name(path)} is missing: it must be given{in_unit}"
    if details["type"] == "refused" and "value" not in context:
        return f"{safe_text.quote_name(path)} is missing: {context['allowed']}"
    value = context.get("value", details["input"])
    if details["type"] == "extra_forbidden":
        allowed = _known_keys(model, location, listed)
    else:
        allowed = _ALLOWED.get(details["type"], _OTHERWISE).format(**context)
    if details["type"] in ("float_type", "int_type") and isinstance(value, str):
        pointed = safe_text.replace_decimal_comma(value)
        allowed += (
            f" without quotes, with a decimal point: {pointed}" if pointed else ", without quotes"
        )
    set_here = any(name == path or name.startswith(f"{path}[") for name in changed)
    return str(value_error(path, value, allowed, is_changed=set_here))


def _known_keys(model: type[BaseModel], location: tuple[str | int, ...], listed: set[str]) -> str:
    """Return what is wrong with an unknown key, with the keys of its table unless they were
    listed.
    """
    *inner, unknown = location
    table = find_section(find_annotation(model, tuple(inner)))
    keys = list(list_fields(table)) if table else []
    similar = paths.find_similar(str(unknown), keys)
    hint = f": did you mean {similar[0]}?" if similar else ""
    all_keys = ", ".join(keys)
    allowed = f" (allowed here: {all_keys})" if keys and all_keys not in listed else ""
    listed.add(all_keys)
    return f"there is no such key{hint}{allowed}"


LEAST, LARGEST = 1e-15, 1e15
"""Of a positive number of a file, and of any in size: beyond any machine's, so that powers and
products stay finite.
"""


NEGLIGIBLE = 1e-100
"""Of any number that is not zero, in size: squares and quotients of smaller ones leave the range of
numbers.
"""


def _not_tiny(value: float) -> float:
    if value < LEAST:
        raise invalid_value_problem("", value, f"it must be at least {LEAST:g}")
    return value


Real = Annotated[float, Field(strict=True, ge=-LARGEST, le=LARGEST)]
Positive = Annotated[Real, Field(gt=0), AfterValidator(_not_tiny)]
NotNegative = Annotated[Real, Field(ge=0)]
Angle = Annotated[Real, Field(ge=-1e6, le=1e6)]
"""An angle [deg] whose rounding is far below a revolution."""
Share = Annotated[Positive, Field(le=1)]
Probability = Annotated[Real, Field(ge=0, le=1)]
Whole = Annotated[int, Field(strict=True)]


def _words(text: str) -> str:
    if any(
        safe_text.is_invisible(char) and char not in safe_text.ALLOWED_CONTROLS for char in text
    ):
        raise invalid_value_problem("", text, "it must hold no control characters")
    return text


def _line(text: str) -> str:
    if any(char in safe_text.ALLOWED_CONTROLS for char in text):
        raise invalid_value_problem("", text, "it must be one line")
    return _words(text)


Words = Annotated[str, AfterValidator(_words)]
"""Text of any number of lines."""
Line = Annotated[str, AfterValidator(_line)]
"""Text of one line."""


def _list_of(count: int) -> BeforeValidator:
    def check(value: Any) -> Any:
        if not isinstance(value, list | tuple) or len(value) != count:
            commas = isinstance(value, list) and len(value) == 2 * count
            hint = " (decimals are written with a point)" if commas else ""
            raise invalid_value_problem("", value, f"it must be a list of {count} numbers{hint}")
        return value

    return BeforeValidator(check)


Pair = Annotated[tuple[Real, Real], _list_of(2)]
Triple = Annotated[tuple[Real, Real, Real], _list_of(3)]
Quadruple = Annotated[tuple[Real, Real, Real, Real], _list_of(4)]
PositiveTriple = Annotated[tuple[Positive, Positive, Positive], _list_of(3)]


Problems = Iterator[PydanticCustomError]


def check(method: Callable[[Any], Problems]) -> Callable[[Any], Problems]:
    """Mark a method of a section as a check, which yields problems."""
    method.checks = True  # type: ignore[attr-defined]
    return method


def _numbers(place: str, value: object) -> Iterator[tuple[str, float]]:
    """Yield the numbers in a value with their paths; sections in it check their own numbers."""
    if isinstance(value, float):
        yield place, value
    elif isinstance(value, dict):
        for key, entry in value.items():
            yield from _numbers(f"{place}.{key}", entry)
    elif isinstance(value, list | tuple):
        for index, entry in enumerate(value):
            yield from _numbers(f"{place}[{index}]", entry)


class FileSection(BaseModel):
    """An immutable table of a file, with a fixed set of keys and finite numbers.

    After the validation of each value all methods marked as `check` run, and all their problems are
    reported.
    """

    model_config = ConfigDict(
        extra="forbid", frozen=True, allow_inf_nan=False, use_attribute_docstrings=True
    )

    @check
    def _numbers_are_not_negligible(self) -> Problems:
        for name, field in type(self).model_fields.items():
            for place, value in _numbers(field.alias or name, getattr(self, name)):
                if 0 < abs(value) < NEGLIGIBLE:
                    yield invalid_value_problem(
                        place, value, f"it must be at least {NEGLIGIBLE:g} in size"
                    )

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        methods = [
            method for owner in reversed(type(self).__mro__) for method in vars(owner).values()
        ]
        raise_problems(
            [
                problem
                for method in methods
                if getattr(method, "checks", False)
                for problem in method(self)
            ]
        )
        return self


def read_range(model: type[BaseModel], path: str) -> tuple[float | None, float | None]:
    """Return the smallest and largest number at a path such as `mass.sun_kg` or
    `nozzle.hinge_A_mm[0]`, in its unit.

    None stands for the general limit of all numbers. Raises KeyError if the class does not have the
    path.
    """
    root = _schema(model)
    node = root
    for part in re.findall(r"[^.\[\]]+", path):
        node = _followed(node, root)
        node = node["prefixItems"][int(part)] if "prefixItems" in node else node["properties"][part]
    low = max(node.get(key, -LARGEST) for key in ("minimum", "exclusiveMinimum"))
    high = min(node.get(key, LARGEST) for key in ("maximum", "exclusiveMaximum"))
    return None if low == -LARGEST else float(low), None if high == LARGEST else float(high)


@cache
def _schema(model: type[BaseModel]) -> dict[str, Any]:
    """Return the JSON schema of a class."""
    return model.model_json_schema()


def _followed(schema: dict[str, Any], root: dict[str, Any]) -> dict[str, Any]:
    """Return the target of a reference; other schemas are returned unchanged."""
    reference: str = schema.get("$ref", "")
    return root["$defs"][reference.rpartition("/")[2]] if reference else schema
