"""Kinds of values in an input file, and the base of its tables.

Values stay as the file shows them, in mm, deg, r/min, kg, N: a key ends in its unit.
"""

from collections.abc import Callable, Iterator
from typing import Annotated, Any, Self

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

from planter import safe_text
from planter.files.complaints import refuse, refused

LEAST, LARGEST = 1e-15, 1e15
"""Of a positive number of a file, and of any in size: beyond any machine's, so that powers and products stay finite."""


NEGLIGIBLE = 1e-100
"""Of any number that is not zero, in size: squares and quotients of smaller ones leave the range of numbers."""


def _not_tiny(value: float) -> float:
    if value < LEAST:
        raise refused("", value, f"it must be at least {LEAST:g}")
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
    if any(safe_text.is_invisible(char) and char not in safe_text.ALLOWED_CONTROLS for char in text):
        raise refused("", text, "it must hold no control characters")
    return text


def _line(text: str) -> str:
    if any(char in safe_text.ALLOWED_CONTROLS for char in text):
        raise refused("", text, "it must be one line")
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
            raise refused("", value, f"it must be a list of {count} numbers{hint}")
        return value

    return BeforeValidator(check)


Pair = Annotated[tuple[Real, Real], _list_of(2)]
Triple = Annotated[tuple[Real, Real, Real], _list_of(3)]
PositiveTriple = Annotated[tuple[Positive, Positive, Positive], _list_of(3)]


Problems = Iterator[PydanticCustomError]


def check(method: Callable[[Any], Problems]) -> Callable[[Any], Problems]:
    """Mark a method of a section as a check, which yields problems: results of `refused` and `lacking`."""
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


class Section(BaseModel):
    """An immutable table of a file, with a fixed set of keys and finite numbers.

    After the validation of each value all methods marked as `check` run, and all their problems are reported.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    @check
    def _numbers_are_not_negligible(self) -> Problems:
        for name, field in type(self).model_fields.items():
            for place, value in _numbers(field.alias or name, getattr(self, name)):
                if 0 < abs(value) < NEGLIGIBLE:
                    yield refused(place, value, f"it must be at least {NEGLIGIBLE:g} in size")

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        methods = [method for owner in reversed(type(self).__mro__) for method in vars(owner).values()]
        refuse([problem for method in methods if getattr(method, "checks", False) for problem in method(self)])
        return self
