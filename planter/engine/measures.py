"""Measures of quantities over a cycle, sums of them, and limits, in the language of files and
options.

    SUM       = ["-"] TERM { ("+" | "-") TERM }
    TERM      = [WEIGHT] MEASURE
    LIMIT     = MEASURE ("<=" | ">=") NUMBER [UNIT]
    MEASURE   = [KIND] ["abs"] NAME [PLACE]
              | "time of" EVENT [SPAN] | "settling" NAME "within" NUMBER [UNIT] [SPAN]
    PLACE     = "at" DEG | "at" SECONDS "s" | "where" NAME "is" ("least" | "greatest")
              | "where" NAME "is" NUMBER [UNIT] ("first" | "last") [SPAN]
              | [SPAN] ["while" CONDITION { "and" CONDITION }]
    SPAN      = "over" SECONDS ".." SECONDS "s"
    EVENT     = words, or anything in quotes: an event of a motion, or what its name holds
    CONDITION = ["abs"] NAME ("<" | "<=" | ">" | ">=") NUMBER [UNIT]
    NAME      = words, as a quantity is printed, or its meaning with its name in brackets
              | "distance" POINT "to" (FILE | POINT) | "clearance" POINT "over" FILE
    POINT     = NAME of a point | NAME NAME, its coordinates

KIND is one of `KINDS`; a measure without one is the quantity at an angle, or everywhere. Numbers
without a unit are in the display unit of the quantity. The text of what is parsed reads back to the
same. What a sum minimises are values as they are: a greatest value or a range can only be made
smaller, a least one only greater, as "-min NAME". A `jump` is the size of the greatest jump where a
law of the machine changes, a distance that of a point from a curve or from another point, a
clearance its height over the profile of a ground (`planter.engine.piecewise`). A point P has the
coordinates x_P and y_P, or P_x and P_y; the point P of a body has the name BODY__P. A FILE with
spaces, or whose name is a single word, has quotes. Of a machine that moves freely measures are of
times: at one, or over a span of them, or at one that the motion decides on: where a quantity passes
a number, the time `t` of an event, or the last time outside a band about the value at the end.

>>> for term in parse_sum("range F_Ox + 0.5 rms M_in while y_tip <= 20 mm"): print(term)
range F_Ox
0.5 rms M_in while y_tip <= 20 mm
>>> print(*parse_sum("rms distance x_tip y_tip to path.csv while y_tip <= 0"))
rms distance x_tip y_tip to path.csv while y_tip <= 0
>>> print(parse_limit("clearance x_A y_A over soil.csv >= 20 mm"), parse_limit("distance x_A y_A to x_B y_B >= 5"))
clearance x_A y_A over soil.csv >= 20 mm distance x_A y_A to x_B y_B >= 5
>>> print(parse_limit("min distance tip to ground__D >= 20 mm"))
min distance tip to ground__D >= 20 mm
>>> print(*parse_sum("max abs F_A over 0..2 s + 3 x at 1 s"), sep="; ")
max abs F_A over 0..2 s; 3 x at 1 s
>>> print(*parse_sum("x where v is 0 m/s first + time of impact over 0..3 s"), sep="; ")
x where v is 0 m/s first; time of "impact" over 0..3 s
>>> print(parse_limit("settling x within 1 mm <= 2 s"))
settling x within 1 mm <= 2 s
>>> print(parse_limit("abs F_Ax <= 300 N"), parse_limit("tilt where y_tip is least <= 10"), sep="; ")
abs F_Ax <= 300 N; tilt where y_tip is least <= 10
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, Never

from planter.errors import InputError
from planter.files.units import parse_unit
from planter.text_files import is_file

Kind = Literal["max", "min", "range", "mean", "variance", "std", "rms", "work", "jump", "at", "all"]
KINDS: tuple[Kind, ...] = ("max", "min", "range", "mean", "variance", "std", "rms", "work", "jump")
"""Measures by their words; `at` and `all`, the value at an angle and everywhere, have none."""
AVERAGES: tuple[Kind, ...] = ("mean", "variance", "std", "rms", "work")
"""Measures that only a cycle has that ends in the state in which it began."""
WITHOUT_SIZE: tuple[Kind, ...] = ("mean", "variance", "std", "work", "min", "range")
"""Measures that have corners of absolute values, which no search takes."""
SMALLER: tuple[Kind, ...] = ("max", "range", "jump")
"""Measures that a search can only make smaller."""
CLAUSES = ("at", "where", "while", "over")
TIME = "t"
"""Name of the time [s] among the quantities of a machine that moves freely."""
SIGNS = ("<=", ">=", "<", ">")
ORDERS = ("first", "last")
TIMES = ("time", "settling")
"""Words before an event or a quantity: a measure of them is a time."""
TYPO = 0.7
"""Likeness from which on a word is a misspelt one of the language, not part of a name."""
LINKS = {"distance": "to", "clearance": "over"}
"""Words before two quantities, unless they are a quantity's name, and the words before what these
are measured from.
"""

SUM_SYNTAX = (
    "it must be a sum (+ or -) of [WEIGHT] MEASURE [abs] NAME, MEASURE one of "
    + ", ".join(KINDS)
    + ", or of NAME at DEG or NAME "
    'where NAME is least|greatest, such as "range F_Ox + 0.5 rms M_in"; of what moves freely over '
    'times or at one, such as "max F_A over 0..2 s + x at 1 s", "x where v is 0 first", "time of '
    'EVENT" or "settling x within 1 mm"'
)
LIMIT_SYNTAX = (
    "it must be [MEASURE] [abs] NAME [at DEG | where NAME is least|greatest | while NAME <= "
    "NUMBER] <= NUMBER [UNIT] "
    '(or >=), such as "abs F_Ax <= 300 N" or "s at 90 >= 150"'
)
MEASURE_SYNTAX = (
    f"it must be MEASURE [abs] NAME, MEASURE one of {', '.join(KINDS)}, or NAME at ANGLE, or NAME "
    f"at SECONDS s, such "
    'as "max F_Ax" or "M_in at 90"'
)


_DISTANCE = re.compile(
    r"(distance|clearance) (\w+(?: \w+)?) (to|over) (?:(\w+(?: \w+)?)|(.+))", re.DOTALL
)
_FILE = re.compile(r"""\"([^"]+)\"|'([^']+)'|([^\s"']+)""")
_BRACKETED = re.compile(
    r"(?:(?!\b(?:where|while)\b)[^()<>+]|\([^()]*\s[^()]*\))*\(([A-Za-z_]\w*)\)"
)
"""A quantity as a page prints it, its meaning with its symbol in brackets."""
_WORD = re.compile(r"\w+(?=[\s<>]|$)")


@dataclass(frozen=True)
class PointDistance:
    """A `word` with a point, and what it is measured from: a curve, or the profile of a ground, of
    a `file`, or else another point.

    A point is its name, or the names of the quantities that are its coordinates.
    """

    word: str
    point: tuple[str, ...]
    file: str = ""
    other: tuple[str, ...] = ()

    def __str__(self) -> str:
        is_plain = re.fullmatch(r"[^\s\"']+", self.file) and not re.fullmatch(r"\w+", self.file)
        quote = "" if is_plain else "'" if '"' in self.file else '"'
        target = " ".join(self.other) or f"{quote}{self.file}{quote}"
        return f"{self.word} {' '.join(self.point)} {LINKS[self.word]} {target}"

    def find_file(self, source: str) -> Path:
        """Return the path of the curve's file: in the folder of a machine's file, or else as it is
        written.
        """
        path = Path(source).parent / self.file
        return path if is_file(path) else Path(self.file)


def parse_distance(name: str) -> PointDistance | None:
    """Return the distance that a name of a quantity means, None for any other.

    >>> print(parse_distance("distance x_tip y_tip to path.csv"), parse_distance("x_tip"))
    distance x_tip y_tip to path.csv None
    """
    match = _DISTANCE.fullmatch(name)
    if match is None or LINKS[match[1]] != match[3]:
        return None
    word, point, _, other, file = match.groups()
    if file is None:
        return PointDistance(word, tuple(point.split()), other=tuple(other.split()))
    return PointDistance(word, tuple(point.split()), file[1:-1] if file[0] in "\"'" else file)


@dataclass(frozen=True)
class Extremum:
    """The angle at which a quantity is greatest (`sign` +1) or least (-1)."""

    name: str
    sign: int

    @property
    def names(self) -> tuple[str, ...]:
        """The name of the quantity."""
        return (self.name,)

    def __str__(self) -> str:
        return f"{self.name} is {'greatest' if self.sign > 0 else 'least'}"


@dataclass(frozen=True)
class Crossing:
    """The angle, or the time, at which a quantity passes a number: for the first time, or the
    `last`.

    The number is in `unit`, or in the display unit of the quantity if that is empty.
    """

    name: str
    number: float
    unit: str = ""
    last: bool = False

    @property
    def names(self) -> tuple[str, ...]:
        """The name of the quantity."""
        return (self.name,)

    def __str__(self) -> str:
        order = "last" if self.last else "first"
        return f"{self.name} is {_text(self.number, self.unit)} {order}"


@dataclass(frozen=True)
class EventTime:
    """The time at which an event of a motion happens first, by its name or a part of that."""

    event: str
    names = ()

    def __str__(self) -> str:
        quote = "'" if '"' in self.event else '"'
        return f"time of {quote}{self.event}{quote}"


@dataclass(frozen=True)
class SettlingBand:
    """The last time at which a quantity is further from its value at the end of the time than a
    number in `unit`, or in the display unit of the quantity if that is empty.
    """

    name: str
    number: float
    unit: str = ""

    @property
    def names(self) -> tuple[str, ...]:
        """The name of the quantity."""
        return (self.name,)

    def __str__(self) -> str:
        return f"settling {self.name} within {_text(self.number, self.unit)}"


Place = Extremum | Crossing | EventTime | SettlingBand


@dataclass(frozen=True)
class MeasureCondition:
    """A quantity, or its size if `absolute`, on one side of a number: at most it (`sign` +1), or at
    least.

    The number is in `unit`, or in the display unit of the quantity if that is empty. `strict` is
    the sign without equality, which is the same part of a cycle.
    """

    name: str
    sign: int
    number: float
    unit: str = ""
    absolute: bool = False
    strict: bool = False

    @property
    def names(self) -> tuple[str, ...]:
        """The name of the quantity."""
        return (self.name,)

    def __str__(self) -> str:
        sign = ("<" if self.sign > 0 else ">") + ("" if self.strict else "=")
        return (
            f"{'abs ' if self.absolute else ''}{self.name} {sign} {_text(self.number, self.unit)}"
        )


@dataclass(frozen=True)
class Measure:
    """A measure of a quantity over a cycle: `all` is its value everywhere, `at` that at an angle.

    The angle is `angle` [deg], or it follows from the design, `where`. With conditions, `during`,
    only the part of the cycle counts on which all hold. `size` takes absolute values. Of a free
    motion `angle` is a time [s] if `in_time` is set, and `span` holds the first and the last time
    [s]. Times of events and of settling are values of the time there.
    """

    kind: Kind
    name: str
    size: bool = False
    weight: float = 1.0
    angle: float | None = None
    in_time: bool = False
    span: tuple[float, float] | None = None
    where: Place | None = None
    during: tuple[MeasureCondition, ...] = ()

    def __str__(self) -> str:
        weight = (
            {1.0: "", -1.0: "-"}.get(self.weight) if abs(self.weight) == 1 else _text(self.weight)
        )
        words = [weight, self.kind if self.kind in KINDS else ""]
        is_time = isinstance(self.where, EventTime | SettlingBand)
        words += ["abs" if self.size else "", str(self.where) if is_time else self.name]
        if self.angle is not None:
            words.append(f"at {_text(self.angle)}{' s' if self.in_time else ''}")
        if self.where is not None and not is_time:
            words.append(f"where {self.where}")
        if self.span is not None:
            words.append(f"over {'..'.join(map(_text, self.span))} s")
        if self.during:
            words.append("while " + " and ".join(map(str, self.during)))
        return " ".join(filter(None, words))

    @property
    def is_size(self) -> bool:
        """Whether the sizes of values count, not the values."""
        return self.size or self.kind == "jump"

    @property
    def is_moving(self) -> bool:
        """Whether the design moves the angles that the measure is of."""
        return self.kind == "jump" or self.where is not None or bool(self.during)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all quantities that the measure speaks of, its own first."""
        where = () if self.where is None else self.where.names
        return (self.name, *where, *(condition.name for condition in self.during))

    def with_whole_paths(self, source: str) -> Measure:
        """Return the measure with whole paths of its curves, which a machine's file names as seen
        from its folder.
        """
        curves = [parse_distance(name) for name in self.names]
        return self.with_names(
            [
                name
                if curve is None or not curve.file
                else str(replace(curve, file=str(curve.find_file(source).resolve())))
                for name, curve in zip(self.names, curves, strict=True)
            ]
        )

    def with_names(self, names: Sequence[str]) -> Measure:
        """Return the measure of other quantities, in the order of `names`."""
        first, *rest = names
        where = self.where
        if where is not None and not isinstance(where, EventTime):
            where = replace(where, name=rest.pop(0))
        during = tuple(
            replace(condition, name=name) for condition, name in zip(self.during, rest, strict=True)
        )
        return replace(self, name=first, where=where, during=during)


@dataclass(frozen=True)
class Limit:
    """A measure with its limit, in `unit` or else in the display unit: at most it (`sign` +1), or
    at least.
    """

    measure: Measure
    sign: int
    number: float
    unit: str = ""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all quantities that the limit speaks of, its own first."""
        return self.measure.names

    def __str__(self) -> str:
        return f"{self.measure} {'<=' if self.sign > 0 else '>='} {_text(self.number, self.unit)}"


def parse_sum(text: str, label: str = "--least") -> tuple[Measure, ...]:
    """Return the measures of a sum that is to be minimised.

    Raises InputError, which begins with `label`.
    """
    reader = _Reader(text, label, SUM_SYNTAX)
    terms = [reader.read_measure(weighted=True)]
    while sign := reader.accept("+", "-"):
        term = reader.read_measure(weighted=True)
        terms.append(replace(term, weight=-term.weight) if sign == "-" else term)
    reader.end()
    for term in terms:
        if term.kind == "all":
            reader.refuse(f"{term.name} needs a measure")
        if term.size and term.kind in WITHOUT_SIZE:
            reader.refuse(f"{term.kind} takes no abs, which has corners")
        if term.kind == "min" and term.weight > 0:
            reader.refuse(f"a least value can only be made greater: write -min {term.name}")
        if term.weight < 0 and (term.kind in SMALLER or (term.kind == "at" and term.size)):
            kind = "abs" if term.kind == "at" else term.kind
            reader.refuse(
                f"{kind} {term.name} can only be made smaller: its weight must not be negative"
            )
    return tuple(terms)


def format_sum(terms: Sequence[Measure]) -> str:
    """Return the text of a sum."""
    text = " + ".join(map(str, terms))
    return re.sub(r" \+ -\s?", " - ", text)


def parse_limit(text: str, label: str = "--hold") -> Limit:
    """Return a limit on a measure. Raises InputError, which begins with `label`."""
    reader = _Reader(text, label, LIMIT_SYNTAX)
    measure = reader.read_measure()
    sign, number, unit = reader.read_bound(("<=", ">="))
    reader.end()
    if measure.size and sign == ">=" and measure.kind != "max":
        reader.refuse("only abs NAME <= and max abs NAME >= are limits")
    if measure.size and measure.kind in WITHOUT_SIZE:
        reader.refuse(f"{measure.kind} takes no abs, which has corners")
    if (measure.kind, sign) == ("jump", ">="):
        reader.refuse("only jump <= is a limit")
    return Limit(measure, 1 if sign == "<=" else -1, number, unit)


def parse_measure(text: str, label: str) -> Measure:
    """Return a single measure, or a quantity at an angle or a time.

    Raises InputError, which begins with `label`.
    """
    reader = _Reader(text, label, MEASURE_SYNTAX)
    measure = reader.read_measure()
    reader.end()
    if measure.kind == "all":
        reader.refuse(f"{measure.name} needs a measure")
    return measure


def _text(number: float, unit: str = "") -> str:
    """Return a number as short as it reads back, with its unit."""
    short = f"{number:g}"
    digits = short if float(short) == number else repr(number)
    return f"{digits} {unit}" if unit else digits


_TOKEN = re.compile(
    r"(?P<number>(?:\d+(?:\.(?!\.)\d*)?|\.\d+)(?:[eE][-+]?\d+)?)|(?P<word>[A-Za-z_]\w*)"
    r"|(?P<sign><=|>=|<|>)|(?P<other>\.\.|\S)"
)


@dataclass(frozen=True)
class _Token:
    kind: str
    text: str
    start: int


class _Reader:
    """A text word by word; complaints name the word and the character at which it begins."""

    def __init__(self, text: str, label: str, syntax: str) -> None:
        self.text, self.label, self.syntax = text, label, syntax
        self.tokens = [_Token(str(m.lastgroup), m[0], m.start()) for m in _TOKEN.finditer(text)]
        self.tokens.append(_Token("end", "", len(text)))
        self.index = 0

    @property
    def token(self) -> _Token:
        return self.tokens[self.index]

    def _next(self, offset: int = 1) -> _Token:
        return self.tokens[min(self.index + offset, len(self.tokens) - 1)]

    def refuse(self, reason: str) -> Never:
        """Raise InputError for the whole text."""
        raise InputError(f"{self.label} {self.text!r}: {reason}; {self.syntax}")

    def fail(self, reason: str, allowed: Sequence[str] = ()) -> Never:
        """Raise InputError for the present word, with a close match among the words that are
        allowed.
        """
        token = self.token
        close = difflib.get_close_matches(token.text, allowed, 1) if token.text else []
        hint = f", did you mean {close[0]}?" if close else ""
        word = f"{token.text!r} at character {token.start + 1}" if token.text else "the end"
        self.refuse(f"{word} {reason}{hint}")

    def accept(self, *texts: str) -> str:
        """Return the present word and go on, if it is one of these, else an empty text."""
        text = self.token.text
        if text not in texts or self.token.kind == "end":
            return ""
        self.index += 1
        return text

    def expect(self, texts: Sequence[str], reason: str) -> str:
        """Return the present word, which must be one of these."""
        return self.accept(*texts) or self.fail(f"{reason}: it must be {' or '.join(texts)}", texts)

    def end(self) -> None:
        """Require the end of the text."""
        if self.token.kind != "end":
            self.fail("is not expected", CLAUSES)

    def read_measure(self, weighted: bool = False) -> Measure:
        """Read a measure, with its weight if it may have one."""
        weight = self._read_weight() if weighted else 1.0
        kind = (
            next((kind for kind in KINDS if kind == self.token.text), None)
            if self._qualifies()
            else None
        )
        self.index += kind is not None
        if kind == "jump" and self.token.text == "abs" and self._qualifies():
            self.fail("does not go with jump, which is a size")
        if kind is None and self.token.text in TIMES and self._qualifies():
            time = self._read_time()
            if time is not None:
                return self._read_end(Measure("at", TIME, False, weight, where=time))
        size = self._qualifies() and bool(self.accept("abs"))
        name = self._read_name(("abs",) if kind else ("abs", *KINDS))
        measure = Measure(kind or "all", name, size, weight)
        clause = self.token.text if self.token.kind == "word" else ""
        if clause in ("at", "where") and kind is not None:
            self.fail(f"does not go with {kind}: NAME {clause} is a single value")
        if clause == "while" and kind == "jump":
            self.fail("does not go with jump: a law changes at angles of its own")
        if self.accept("at"):
            angle = self._read_number()
            in_time = bool(self.accept("s"))
            if not in_time:
                self.accept("deg")
            return replace(measure, kind="at", angle=angle, in_time=in_time)
        if self.accept("where"):
            return self._read_end(replace(measure, kind="at", where=self._read_place()))
        measure = self._read_end(measure)
        if self.accept("while"):
            return replace(measure, during=self._read_conditions())
        return measure

    def _read_end(self, measure: Measure) -> Measure:
        """Return a measure with the span of time that may follow it."""
        return replace(measure, span=self._read_span()) if self.accept("over") else measure

    def _read_time(self) -> EventTime | SettlingBand | None:
        """Read the time of an event or of settling; None for a name that begins with such a word."""
        word, start = self.token.text, self.index
        self.index += 1
        if word == "time":
            if self.accept("of"):
                return EventTime(self._read_event())
        else:
            name = self._read_words(("within",))
            if self.accept("within"):
                number = self._read_number()
                if number <= 0:
                    self.refuse("the band of settling is wider than 0")
                return SettlingBand(name, number, self._read_unit(CLAUSES))
        self.index = start
        return None

    def _read_event(self) -> str:
        """Read the name of an event: words up to a clause or a sign, or anything in quotes."""
        start = self.token.start
        if self.token.text in ("'", '"'):
            match = _FILE.match(self.text, start)
            if match is None:
                self.fail("opens a quote that nothing closes")
            while self.token.kind != "end" and self.token.start < match.end():
                self.index += 1
            return "".join(filter(None, match.groups()))
        ends = (*CLAUSES, "+", "-")
        while self.token.kind not in ("sign", "end") and self.token.text not in ends:
            self.index += 1
        event = self.text[start : self.token.start].strip()
        return event or self.fail("is no event")

    def _read_span(self) -> tuple[float, float]:
        first = self._read_number()
        self.expect(("..",), "is not expected: a span of time is SECONDS..SECONDS s")
        last = self._read_number()
        self.expect(("s",), "is not expected: a span of time is in s")
        if not 0 <= first < last:
            self.refuse("a span of time begins at 0 s or later, and ends after that")
        return first, last

    def read_bound(self, signs: Sequence[str]) -> tuple[str, float, str]:
        """Read a sign, a number and the unit that may follow it."""
        sign = self.expect(signs, "is not expected") if self.token.kind == "sign" else ""
        if not sign:
            self.fail(
                "is not expected: a limit is missing"
                if self.token.kind == "end"
                else "is not expected",
                CLAUSES,
            )
        return sign, self._read_number(), self._read_unit()

    def _qualifies(self) -> bool:
        """Return whether the present word stands before a name, as a measure or abs does."""
        following = self._next()
        return (
            self.token.kind == "word" and following.kind == "word" and following.text not in CLAUSES
        )

    def _read_weight(self) -> float:
        sign = -1.0 if self.accept("-", "+") == "-" else 1.0
        if self.token.kind != "number":
            return sign
        weight = sign * self._read_number()
        self.accept("*")
        return weight

    def _read_name(self, before: Sequence[str]) -> str:
        """Read a name; `before` are the words that may precede it."""
        if self.token.kind != "word":
            self.fail("is no name of a quantity")
        if bracketed := _BRACKETED.match(self.text, self.token.start):
            while self.token.kind != "end" and self.token.start < bracketed.end():
                self.index += 1
            return bracketed[1]
        if self.token.text in LINKS and self._qualifies() and self._next().text != "is":
            return self._read_distance()
        is_typo = self._next().text in (*KINDS, "abs") or difflib.get_close_matches(
            self.token.text, (*before, *LINKS), 1, TYPO
        )
        if (
            self._qualifies()
            and is_typo
            and not difflib.get_close_matches(self._next().text, CLAUSES)
        ):
            self.fail("is no measure", (*before, *LINKS))
        return self._read_words()

    def _read_words(self, ends: Sequence[str] = ("is", "and")) -> str:
        """Read a name as a page prints it, of words up to a clause or an end: `bearing A1`."""
        words: list[str] = []
        while self.token.kind == "word" or (words and self.token.kind == "number"):
            if words and (self.token.text in (*CLAUSES, *ends) or self._is_misspelt_clause()):
                break
            words.append(self.token.text)
            self.index += 1
        return " ".join(words)

    def _is_misspelt_clause(self) -> bool:
        return self.token.text != "abs" and bool(
            difflib.get_close_matches(self.token.text, CLAUSES, 1, TYPO)
        )

    def _read_distance(self) -> str:
        """Read a distance or a clearance, and return it as the name of a quantity."""
        word = self.token.text
        form = "a distance is one of POINT to FILE, or to POINT"
        form = form if word == "distance" else "a clearance is one of POINT over FILE"
        form += "; POINT is a name, or two names of coordinates"
        self.index += 1
        point = self._read_point(form, (LINKS[word],))
        self.expect((LINKS[word],), f"is not expected: {form}")
        start = self.token.start
        if word == "distance" and _WORD.match(self.text, start):
            return str(
                PointDistance(word, point, other=self._read_point(form, (*CLAUSES, "is", "and")))
            )
        match = _FILE.match(self.text, start)
        if match is None:
            self.fail(
                "is no file" if self.token.kind == "end" else "opens a quote that nothing closes"
            )
        while self.token.kind != "end" and self.token.start < match.end():
            self.index += 1
        return str(PointDistance(word, point, "".join(filter(None, match.groups()))))

    def _read_point(self, form: str, after: Sequence[str]) -> tuple[str, ...]:
        """Read the name of a point, or the names of two coordinates, up to one of the words that
        may come after.
        """
        names: list[str] = []
        while not names or (
            len(names) == 1 and self.token.kind == "word" and self.token.text not in after
        ):
            if self.token.kind != "word" or self.token.text in LINKS.values():
                self.fail(f"is no name of a point or a quantity: {form}")
            names.append(self.token.text)
            self.index += 1
        return tuple(names)

    def _read_number(self) -> float:
        sign = self.accept("-", "+")
        if self.token.kind != "number":
            self.fail("is no number")
        self.index += 1
        return float(sign + self.tokens[self.index - 1].text)

    def _read_unit(self, ends: Sequence[str] = ()) -> str:
        """Read a unit, which ends at `and`, a sign, a plus, the end or one of further words."""
        begin, ends = self.index, (*ends, "and", "+", "-")
        while self.token.kind not in ("sign", "end") and self.token.text not in ends:
            self.index += 1
        unit = self.text[self.tokens[begin].start : self.token.start].strip()
        try:
            parse_unit(unit)
        except ValueError as error:
            self.index = begin
            self.fail(f"is not a unit ({error})")
        return unit

    def _read_place(self) -> Extremum | Crossing:
        is_distance = self.token.text in LINKS and self._next().text != "is"
        name = self._read_distance() if is_distance else self._read_words()
        self.expect(("is",), "is not expected")
        if self.token.kind == "number" or self.token.text in ("+", "-"):
            number, unit = self._read_number(), self._read_unit(ORDERS)
            order = self.expect(ORDERS, "is not expected")
            return Crossing(name, number, unit, order == "last")
        return Extremum(
            name, 1 if self.expect(("least", "greatest"), "is no extreme") == "greatest" else -1
        )

    def _read_conditions(self) -> tuple[MeasureCondition, ...]:
        conditions: list[MeasureCondition] = []
        while not conditions or self.accept("and"):
            absolute = self._qualifies() and bool(self.accept("abs"))
            name = self._read_name(("abs",))
            if self.token.kind != "sign":
                self.fail("is not expected: a condition is NAME <= NUMBER")
            sign, number, unit = self.read_bound(SIGNS)
            conditions.append(
                MeasureCondition(
                    name, 1 if "<" in sign else -1, number, unit, absolute, "=" not in sign
                )
            )
        return tuple(conditions)
