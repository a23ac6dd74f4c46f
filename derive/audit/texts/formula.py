"""Formulas in LaTeX as trees: what stands in print, each part with its place, before anything is
known of its names.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from fractions import Fraction
from itertools import islice, pairwise
from typing import NamedTuple, NoReturn

from .documents import find_group_end


def _words(*texts: str) -> frozenset[str]:
    return frozenset(word for text in texts for word in text.split())


GREEK = _words(
    "alpha beta gamma delta epsilon varepsilon zeta eta theta vartheta iota kappa lambda mu nu xi "
    "pi varpi rho varrho",
    "sigma varsigma tau upsilon phi varphi chi psi omega Gamma Delta Theta Lambda Xi Pi Sigma "
    "Upsilon Phi Psi Omega",
    "ell hbar nabla",
)
DOTS = {"dot": 1, "ddot": 2, "dddot": 3}
VECTOR_ACCENTS = _words(
    "vec bar overline underline mathbf boldsymbol bm pmb hat widehat overrightarrow"
)
ACCENTS = VECTOR_ACCENTS | _words("tilde widetilde check breve mathcal mathbb mathfrak mathscr")
FONTS = _words(
    "mathrm text textrm textnormal mathit textit mathsf textsf mbox operatorname mathop "
    "mathnormal rm it sf"
)
FUNCTIONS = {
    **{
        name: name
        for name in _words("sin cos tan cot sec csc sinh cosh tanh exp ln log sqrt sgn min max")
    },
    **{f"arc{name}": f"a{name}" for name in ("sin", "cos", "tan")},
    **{f"a{name}": f"a{name}" for name in ("sin", "cos", "tan")},
    "sign": "sgn",
    "arctg": "atan",
    "tg": "tan",
    "ctg": "cot",
    "atan2": "atan2",
    "Sin": "sin",
    "Cos": "cos",
    "Tan": "tan",
    "arctan2": "atan2",
    "abs": "abs",
}
"""Printed names of functions with their own names."""
INVERSE = {"sin": "asin", "cos": "acos", "tan": "atan"}
RELATIONS = {
    **dict.fromkeys(("=", "\\equiv", ":=", "\\triangleq", "\\coloneqq"), "="),
    **dict.fromkeys(("<", "\\lt"), "<"),
    **dict.fromkeys((">", "\\gt"), ">"),
    **dict.fromkeys(("\\le", "\\leq", "\\leqslant", "\\leqq"), "<="),
    **dict.fromkeys(("\\ge", "\\geq", "\\geqslant", "\\geqq"), ">="),
    **dict.fromkeys(("\\approx", "\\simeq", "\\cong"), "~"),
}
"""Printed relations with their own; ``~`` is that of an approximation."""
UNREAD_RELATIONS = _words(
    r"\neq \ne \propto \sim \in \to \rightarrow \Rightarrow \implies \mapsto \ll \gg"
)
_UPRIGHT = _words("operatorname mathrm text rm mathop mbox textrm")
_SILENT = _words(
    r"\quad \qquad \displaystyle \textstyle \scriptstyle \nonumber \notag \limits \nolimits "
    r"\noindent \allowbreak",
    r"\thinspace \medspace \enspace \left \right \middle \big \Big \bigg \Bigg \bigl \bigr \Bigl "
    r"\Bigr \biggl \biggr",
    r"\Biggl \Biggr \mathstrut \strut \, \; \: \! \/ ~ & \\ \\* \cr \newline",
) | {"\\ ", "\\\n"}
_OPEN, _CLOSE = (
    {"(": ")", "[": "]", "\\{": "\\}", "\\lbrace": "\\rbrace"},
    {")", "]", "\\}", "\\rbrace"},
)
CONDITION_WORDS = _words("if for when otherwise else elsewhere")
"""Words in the conditions of cases; joined conditions are not read."""
_BARS = {
    "|": "|",
    "\\lvert": "\\rvert",
    "\\vert": "\\vert",
    "\\|": "\\|",
    "\\lVert": "\\rVert",
    "\\Vert": "\\Vert",
}
MATRICES = {
    "matrix": "",
    "bmatrix": "",
    "pmatrix": "",
    "Bmatrix": "",
    "smallmatrix": "",
    "array": "",
    "vmatrix": "det",
}
_TOKEN = re.compile(r"\s*(\\[A-Za-z]+\*?|\\.|:=|\d+(?:\.\d+)?|\.\d+|[A-Za-z]|'+|\S)", re.S)
_UNREAD_COMMANDS = _words(
    r"\label \tag \tag* \hspace \vspace \hspace* \eqno \color \vphantom \hphantom \phantom "
    r"\intertext"
)
"""Commands that are passed over with their argument."""
_SIGNS = ("+", "-", "\\pm", "\\mp", "\u2212")
_TIMES = ("\\cdot", "\\times", "\\ast", "*", "\\wedge")
_AFTER_FACTOR = frozenset(
    (
        *_SIGNS,
        *_TIMES,
        *_CLOSE,
        *RELATIONS,
        *UNREAD_RELATIONS,
        *_words(r"} , . ; / \div _ \end ! '"),
    )
)
"""What begins no factor."""
_MOST_EXPANSIONS = 1000
_MOST_TOKENS, _MOST_CHARACTERS, _MOST_DIGITS = 2000, 100_000, 100
"""Tokens of a formula, characters of it with its macros written out, and digits of a number."""
_MOST_TERMS = 50
"""Terms of a sum over an index."""


class FormulaError(ValueError):
    """A formula that is not read, with the place at which reading ended."""


class Token(NamedTuple):
    """A token of a formula: its text, and the range of the source that it stands for.

    ``fixed`` says that it comes from a macro, so that its range is that of the macro's use.
    """

    text: str
    start: int
    end: int
    fixed: bool = False


@dataclass(frozen=True)
class Symbol:
    """A name as it is printed: nucleus with accents, subscript, primes, dots, and frames before and
    after it.
    """

    stem: str
    accents: tuple[str, ...] = ()
    subscript: str = ""
    primes: int = 0
    dots: int = 0
    before: str = ""
    after: str = ""

    @property
    def base(self) -> Symbol:
        """The name without its dots."""
        return replace(self, dots=0)

    @property
    def is_vector(self) -> bool:
        """Whether an accent marks the name as that of a vector or matrix."""
        return any(accent in VECTOR_ACCENTS for accent in self.accents)

    def spell(self) -> str:
        """Return the one LaTeX spelling by which a name is looked up."""
        word = self.stem.removeprefix("\\")
        nucleus = (
            self.stem
            if len(word) == 1 or self.stem.startswith("\\")
            else rf"\mathrm{{{self.stem}}}"
        )
        for accent in reversed(self.accents):
            nucleus = rf"\{accent}{{{nucleus}}}"
        if self.dots:
            nucleus = rf"\{'d' * self.dots}ot{{{nucleus}}}"
        before = f"^{{{self.before}}}" if self.before else ""
        below = f"_{{{self.subscript}}}" if self.subscript else ""
        above = f"^{{{self.after}}}" if self.after else ""
        return f"{before}{nucleus}{below}{above}{chr(39) * self.primes}"


@dataclass(frozen=True)
class Node:
    """A part of a formula and the range of the source that it was read from."""

    start: int
    end: int


@dataclass(frozen=True)
class Number(Node):
    """A number."""

    value: Fraction


@dataclass(frozen=True)
class Constant(Node):
    """A constant: pi, or the base of exponentials under a power."""

    name: str


@dataclass(frozen=True)
class Name(Node):
    """A name."""

    symbol: Symbol


@dataclass(frozen=True)
class Sum(Node):
    """Signs (1, -1, or 2 and -2 for plus-minus and minus-plus) with their terms."""

    terms: tuple[tuple[int, Node], ...]


@dataclass(frozen=True)
class Product(Node):
    """Factors, each with the operator before it: ``\\cdot``, ``\\times``, or empty for juxtaposed
    ones.
    """

    factors: tuple[tuple[str, Node], ...]


@dataclass(frozen=True)
class Slash(Node):
    """A quotient on one line: what stands above, the factor after the slash, and juxtaposed factors
    after that.
    """

    above: Node
    below: Node
    rest: tuple[tuple[str, Node], ...]


@dataclass(frozen=True)
class Quotient(Node):
    """A fraction."""

    above: Node
    below: Node


@dataclass(frozen=True)
class Power(Node):
    """A power.

    ``script`` is the spelling of an exponent of letters alone, which may be part of the name below
    it.
    """

    base: Node
    exponent: Node
    script: str = ""

    @property
    def symbol(self) -> Symbol | None:
        """The name that base and exponent are together if they are one, None for what can only be a
        power.
        """
        return (
            replace(self.base.symbol, after=self.script)
            if isinstance(self.base, Name) and self.script
            else None
        )


@dataclass(frozen=True)
class Transposed(Node):
    """A transposed matrix."""

    base: Node


@dataclass(frozen=True)
class Bracket(Node):
    """Parts in brackets, between commas if several."""

    parts: tuple[Node, ...]


@dataclass(frozen=True)
class Magnitude(Node):
    """An absolute value, a norm or a determinant."""

    inner: Node


@dataclass(frozen=True)
class FunctionCall(Node):
    """A function of arguments in brackets; or of the first of juxtaposed ``factors``, as their
    units say.
    """

    function: str
    arguments: tuple[Node, ...]
    factors: tuple[tuple[str, Node], ...] = ()
    negative: bool = False
    exponent: Node | None = None


@dataclass(frozen=True)
class Derivative(Node):
    """A derivative to time of an order (``by`` is None), or to a name: the partial one, or the
    first if ``is_total``.

    ``seen_from`` names the frame of the observer of a vector's change in time, empty if the text
    names none.
    """

    inner: Node
    order: int = 1
    by: Symbol | None = None
    seen_from: str = ""
    is_total: bool = False


@dataclass(frozen=True)
class Matrix(Node):
    """A matrix by rows; ``kind`` is "det" for a determinant."""

    rows: tuple[tuple[Node, ...], ...]
    kind: str = ""


@dataclass(frozen=True)
class Cases(Node):
    """Values, each with a chain of relations under which it holds, or None for all others."""

    pieces: tuple[tuple[Node, RelationChain | None], ...]


@dataclass(frozen=True)
class Heading(Node):
    """A sum sign before a name, as in the heading of a balance: what it adds up is what follows."""


@dataclass(frozen=True)
class RelationChain(Node):
    """Sides with the relations between them, as in a = b = c."""

    sides: tuple[Node, ...]
    relations: tuple[str, ...]


def tokenize_formula(
    latex: str, macros: Mapping[str, tuple[int, str]] | None = None
) -> list[Token]:
    """Return the tokens of a formula without blanks and layout, macros expanded.

    Raises FormulaError for a macro that expands without end or lacks an argument.
    """
    expanded = list(islice(_expand(latex, macros or {}, 0, None, [0]), _MOST_TOKENS + 1))
    if len(expanded) > _MOST_TOKENS:
        raise FormulaError(f"it has more than {_MOST_TOKENS} signs: give parts of it a name")
    tokens = _drop_null_delimiters(expanded)
    return _join_functions([token for token in tokens if token.text not in _SILENT])


def _join_functions(tokens: list[Token]) -> list[Token]:
    """Return the tokens with the letters of sin, cos or tan as one, where no blank and no other
    letter follows them.

    Texts write gcos{x}, mcos^2(x) or vtan\\delta; a product of just these letters is no ordinary
    one.
    """
    joined: list[Token] = []
    start = 0
    for index in range(len(tokens) - 3):
        if tokens[index].text not in ("s", "c", "t") or index < start:
            continue
        letters, last = tokens[index : index + 3], tokens[index + 3].text
        word = "".join(token.text for token in letters)
        if word not in ("sin", "cos", "tan") or any(a.end != b.start for a, b in pairwise(letters)):
            continue
        if last in _OPEN or last in ("{", "^") or last[1:] in GREEK or last[1:] in ACCENTS:
            joined += tokens[start:index]
            joined.append(Token(f"\\{word}", letters[0].start, letters[2].end, letters[0].fixed))
            start = index + 3
    return joined + tokens[start:]


def _expand(
    latex: str,
    macros: Mapping[str, tuple[int, str]],
    offset: int,
    place: tuple[int, int] | None,
    count: list[int],
) -> Iterator[Token]:
    position = 0
    while match := _TOKEN.match(latex, position):
        text = match[1]
        start, position = match.span(1)
        if text in _UNREAD_COMMANDS:
            begin = latex.find("{", position)
            position = (find_group_end(latex, begin) or len(latex)) if begin >= 0 else position
            continue
        if text in macros:
            count[0] += 1
            if count[0] > _MOST_EXPANSIONS:
                raise FormulaError(f"the macro {text} expands without end")
            body, position = _apply_macro(latex, position, text, macros)
            yield from _expand(body, macros, 0, place or (offset + start, offset + position), count)
            continue
        if place is None:
            yield Token(text, offset + start, offset + position)
        else:
            yield Token(text, *place, fixed=True)


def expand_matrix_macros(latex: str, macros: Mapping[str, tuple[int, str]]) -> str:
    """Return a formula with the macros written out that hold environments or the marks between the
    cells of one.

    Raises FormulaError for a macro that expands without end or lacks an argument.
    """
    structural = {name for name, (_, body) in macros.items() if re.search(r"\\begin|\\\\|&", body)}
    while (
        inner := {name for name, (_, body) in macros.items() if _uses(body, structural)}
        - structural
    ):
        structural |= inner
    for _ in range(_MOST_EXPANSIONS):
        match = next(
            (m for m in re.finditer(r"\\[A-Za-z]+", latex) if m.group() in structural), None
        )
        if match is None:
            return latex
        body, position = _apply_macro(latex, match.end(), match.group(), macros)
        latex = latex[: match.start()] + body + latex[position:]
        if len(latex) > _MOST_CHARACTERS:
            raise FormulaError(
                f"with its macros written out it has more than {_MOST_CHARACTERS} characters"
            )
    raise FormulaError("a macro expands without end")


def _uses(body: str, names: set[str]) -> bool:
    return not names.isdisjoint(re.findall(r"\\[A-Za-z]+", body))


def _apply_macro(
    latex: str, position: int, macro: str, macros: Mapping[str, tuple[int, str]]
) -> tuple[str, int]:
    """Return the body of a macro with its arguments, and the position after them."""
    size, body = macros[macro]
    arguments = []
    for _ in range(size):
        argument, position = _argument(latex, position, macro)
        arguments.append(argument)
    body = re.sub(r"#(\d)", lambda match: arguments[int(match.group(1)) - 1], body)
    return body, position


def _argument(latex: str, position: int, macro: str) -> tuple[str, int]:
    match = re.compile(r"\s*(?:(\{)|(\\[A-Za-z]+|\S))").match(latex, position)
    end = (
        find_group_end(latex, match.start(1)) if match and match.group(1) else match and match.end()
    )
    if match is None or end is None:
        raise FormulaError(f"the macro {macro} lacks an argument")
    return (latex[match.start(1) + 1 : end - 1] if match.group(1) else match.group(2)), end


def _drop_null_delimiters(tokens: list[Token]) -> Iterator[Token]:
    """Yield the tokens without the points of ``\\left.`` and ``\\right.``."""
    for before, token in zip([None, *tokens], tokens, strict=False):
        if token.text == "." and before is not None and before.text in ("\\left", "\\right"):
            continue
        yield token


@dataclass
class Reader:
    """Recursive descent over the tokens of a formula.

    Errors are FormulaError with the place in the source.
    """

    latex: str
    tokens: list[Token]
    at: int = 0
    bars: list[str] = field(default_factory=list)
    brackets: dict[tuple[str, ...], Bracket] | None = None
    """Brackets of other formulas by their tokens, of which the parts are read once, with the places
    of the first.
    """

    def peek(self, ahead: int = 0) -> str:
        """Return the text of a token, empty after the end."""
        index = self.at + ahead
        return self.tokens[index].text if index < len(self.tokens) else ""

    def take(self, *texts: str) -> Token:
        """Return the next token, which must have one of some texts if there are any."""
        if self.at >= len(self.tokens):
            raise FormulaError("the formula ends too soon")
        token = self.tokens[self.at]
        if texts and token.text not in texts:
            self.fail(f"{' or '.join(texts)} is missing before {token.text}")
        self.at += 1
        return token

    def fail(self, reason: str) -> NoReturn:
        """Raise FormulaError with what stands around the next token."""
        if not self.tokens:
            raise FormulaError(reason)
        token = self.tokens[min(self.at, len(self.tokens) - 1)]
        before = " ".join(self.latex[max(0, token.start - 16) : token.start].split())
        after = " ".join(self.latex[token.start : token.start + 24].split())
        raise FormulaError(f"{reason}, at ... {before} >>> {after} ...")

    def finish(self) -> None:
        """Refuse what is left."""
        if self.peek():
            self.fail(f"{self.peek()} is not read here")

    @contextmanager
    def _looking_ahead(self) -> Iterator[None]:
        mark, tokens = self.at, list(self.tokens)
        try:
            yield
        finally:
            self.at, self.tokens = mark, tokens

    def _position(self) -> int:
        return self.tokens[self.at].start if self.at < len(self.tokens) else len(self.latex)

    def _end(self) -> int:
        return self.tokens[self.at - 1].end if self.at else 0

    def chain(self) -> RelationChain:
        """Read sides and relations up to the end, where a comma or full stop may stand."""
        start = self._position()
        sides: list[Node] = []
        relations: list[str] = []
        while True:
            is_heading = self.peek() == "\\sum" and self.peek(1) not in ("_", "^")
            sides.append(self._heading() if is_heading else self.sum())
            text = self.peek()
            if text in RELATIONS:
                relations.append(RELATIONS[self.take().text])
                if self.peek() == text and "\\\\" in self.latex[self._end() : self._position()]:
                    self.take()  # a relation at the end of a line stands again at the beginning of the next
                continue
            if text in UNREAD_RELATIONS:
                self.fail(f"the relation {text} is not one that can be judged")
            while self.peek() in (",", ".", ";"):
                self.take()
            self.finish()
            return RelationChain(start, self._end(), tuple(sides), tuple(relations))

    def _heading(self) -> Node:
        start = self.take().start
        while self.peek() and self.peek() not in RELATIONS:
            self.take()
        if not self.peek():
            self.fail("a sum sign without a relation after it")
        return Heading(start, self._end())

    def sum(self) -> Node:
        """Read terms with their signs."""
        start = self._position()
        terms = self.terms()
        return build_sum(start, terms, self._end())

    def terms(self) -> tuple[tuple[int, Node], ...]:
        """Read terms with their signs, and return both."""
        terms = [(self._sign(), self.term())]
        while self.peek() in _SIGNS:
            terms.append((self._sign(), self.term()))
        return tuple(terms)

    def _sign(self) -> int:
        sign = 1
        while self.peek() in _SIGNS:
            sign *= {"+": 1, "\\pm": 2, "\\mp": -2}.get(self.take().text, -1)
        if abs(sign) > 2:
            self.fail("several plus-minus signs before one term are not read")
        return sign

    def term(self) -> Node:
        """Read factors: juxtaposed, with an operator, or under a slash."""
        start = self._position()
        factors: list[tuple[str, Node]] = [("", self.factor())]
        while True:
            text = self.peek()
            if text in _TIMES:
                self.take()
                factors.append((text, self._signed()))
            elif text in ("/", "\\div"):
                self.take()
                above = (
                    factors[0][1]
                    if len(factors) == 1
                    else Product(start, self._end(), tuple(factors))
                )
                below = self._signed()
                rest: list[tuple[str, Node]] = []
                while self._begins_factor():
                    rest.append(("", self.factor()))
                factors = [("", Slash(start, self._end(), above, below, tuple(rest)))]
            elif self._begins_factor():
                factors.append(("", self.factor()))
            else:
                break
        return factors[0][1] if len(factors) == 1 else Product(start, self._end(), tuple(factors))

    def _signed(self) -> Node:
        start = self._position()
        if self.peek() in ("-", "+", "\u2212"):
            sign = self._sign()
            inner = self.factor()
            return inner if sign == 1 else Sum(start, self._end(), ((sign, inner),))
        return self.factor()

    def _begins_factor(self) -> bool:
        text = self.peek()
        if text == "^":
            return self._is_frame_before()
        if not text or text in _AFTER_FACTOR:
            return False
        return not (self.bars and text == self.bars[-1]) and not text.startswith("'")

    def factor(self) -> Node:
        """Read a part with its powers."""
        start = self._position()
        mark, is_braced = self.at, self.peek() == "{"
        base = self._primary()
        if is_braced:
            self._check_braced(base, mark)
        while self.peek() == "^" and not self._is_frame_before():
            self.take()
            base = self._power(base, start)
        if self.peek() == "!" or self.peek().startswith("'"):
            self.fail(f"{self.peek()} after a bracket is not read")
        return base

    def _check_braced(self, node: Node, mark: int) -> None:
        """Refuse a sum or product in braces that print no brackets, where they would change what is
        read.
        """
        before = self.tokens[mark - 1].text if mark else ""
        if isinstance(node, Sum) and len(node.terms) > 1:
            is_alone = not before or before in ("+", ",", *_OPEN, *_BARS, *RELATIONS)
            if not is_alone or self._begins_factor() or self.peek() in ("^", "/", *_TIMES):
                self.fail("braces print no brackets around a sum")
        elif isinstance(node, Product) and self.peek() == "^" and not self._is_frame_before():
            self.fail("braces print no brackets around a product")

    def _power(self, base: Node, start: int) -> Node:
        group_start, inner = self._group()
        texts = [token.text for token in inner]
        if "".join(texts) in ("\\circ", "\\degree"):
            return Product(
                start, self._end(), (("", base), ("", Constant(group_start, self._end(), "degree")))
            )
        if _transposes(texts):
            return Transposed(start, self._end(), base)
        exponent = self._read_all(inner)
        script = "".join(texts) if isinstance(base, Name) and all(map(str.isalpha, texts)) else ""
        power = Power(start, self._end(), base, exponent, script)
        if self.peek() == "_":
            if not isinstance(base, Name) or base.symbol.subscript:
                self.fail("a subscript after a power is read on a name only")
            self.take()
            subscript = self._spell_group()
            base = Name(base.start, self._end(), replace(base.symbol, subscript=subscript))
            power = replace(power, end=self._end(), base=base)
        return self._of_time(power) if isinstance(base, Name) else power

    def _read_all(self, inner: list[Token], read: Callable[[Reader], Node] | None = None) -> Node:
        """Read a sum, or what else ``read`` reads, up to the end of some tokens."""
        reader = Reader(self.latex, inner)
        if not inner:
            self.fail("an empty group")
        node = (read or Reader.sum)(reader)
        reader.finish()
        return node

    def _read_name(self, inner: list[Token]) -> Symbol | None:
        """Return the name that some tokens are, None if they are none."""
        reader = Reader(self.latex, list(inner))
        symbol = reader.try_symbol() if inner else None
        return None if reader.peek() else symbol

    def _take_nested(self, opening: str, closing: str) -> list[Token]:
        """Take the tokens up to the one that closes what was opened before them."""
        inner: list[Token] = []
        depth = 1
        while True:
            token = self.take()
            depth += (token.text == opening) - (token.text == closing)
            if depth == 0:
                return inner
            inner.append(token)

    def _group(self) -> tuple[int, list[Token]]:
        """Return the start of a braced group, or of the one token that stands for it, and the
        tokens in it.
        """
        token = self.take()
        if token.text == "{":
            return token.start, self._take_nested("{", "}")
        if re.fullmatch(r"\d{2,}|\d+\.\d*", token.text):  # \frac12 and x^12 take one digit
            first = Token(token.text[0], token.start, token.start + 1, token.fixed)
            rest = token.text[1:]
            self.tokens.insert(self.at, Token(rest, token.start + 1, token.end, token.fixed))
            self.tokens[self.at - 1] = first
            return token.start, [first]
        if token.text.startswith("\\") and token.text[1:] in ACCENTS | FONTS | DOTS.keys():
            start = self.at
            self._group()
            return token.start, [token, *self.tokens[start : self.at]]
        return token.start, [token]

    def _spell_group(self) -> str:
        """Return a subscript or superscript in its one spelling: without fonts, braces and
        blanks.
        """
        _, inner = self._group()
        out = ""
        for token in inner:
            text = token.text
            if text in ("{", "}") or (text.startswith("\\") and text[1:] in FONTS):
                continue
            if text[0] == "\\" and text[1:].isalpha():
                out += text + " "
            else:
                out += text
        return re.sub(r" (?![A-Za-z])", "", out).strip()

    def _primary(self) -> Node:
        text, start = self.peek(), self._position()
        if not text:
            raise FormulaError("the formula ends too soon")
        if re.fullmatch(r"\d+(?:\.\d+)?|\.\d+", text):
            self.take()
            if self.peek() == "," and re.fullmatch(r"\d+", self.peek(1)) and self._touches():
                self.fail("a comma between digits is not read: write a decimal point")
            if len(text) > _MOST_DIGITS:
                self.fail(f"a number has more than {_MOST_DIGITS} digits")
            return Number(start, self._end(), Fraction(text))
        if text in _OPEN:
            return self._bracket()
        if text in _BARS:
            return self._magnitude()
        if text == "{":
            return self._braced()
        if text == "^":
            return self._framed()
        if text[0] != "\\":
            if text.isalpha():
                return self._named()
            self.fail(f"{text} is not read here")
        return self._command(text[1:].rstrip("*"), start)

    def _touches(self) -> bool:
        first, second, third = self.tokens[self.at - 1 : self.at + 2]
        return first.end == second.start and second.end == third.start

    def _bracket(self) -> Node:
        if self.brackets is None:
            return self._read_bracket()
        start, end = self.at, self._find_closing()
        tokens = self.tokens[start:end]
        touching = (str(first.end == second.start) for first, second in pairwise(tokens))
        key = (*self.bars, *(token.text for token in tokens), *touching)
        if key in self.brackets:
            self.at = end
        else:
            bracket = self._read_bracket()
            if self.at != end:
                return bracket
            self.brackets[key] = bracket
        return Bracket(self.tokens[start].start, self._end(), self.brackets[key].parts)

    def _find_closing(self) -> int:
        """Return the index after the bracket that closes the one that opens here, that of the end
        if none does.
        """
        depth, (opening, closing) = 0, (self.peek(), _OPEN[self.peek()])
        for index in range(self.at, len(self.tokens)):
            depth += (self.tokens[index].text == opening) - (self.tokens[index].text == closing)
            if depth == 0:
                return index + 1
        return len(self.tokens)

    def _read_bracket(self) -> Bracket:
        opening = self.take()
        parts = [self.sum()]
        while self.peek() == ",":
            self.take()
            parts.append(self.sum())
        if self.peek() != _OPEN[opening.text]:
            self.fail(f"the bracket {opening.text} is not closed")
        self.take()
        return Bracket(opening.start, self._end(), tuple(parts))

    def _magnitude(self) -> Node:
        opening = self.take()
        closing = _BARS[opening.text]
        double = opening.text == "|" and self.peek() == "|"
        if double:
            self.take()
        self.bars.append(closing)
        inner = self.sum()
        self.bars.pop()
        self.take(closing)
        if double:
            self.take(closing)
        if self.peek() == "_":
            self.fail("a value at a place, or a norm with an index, is not read")
        return Magnitude(opening.start, self._end(), inner)

    def _braced(self) -> Node:
        """Read a braced group: a name if it is one, as {q_1} is, or a frame before a name, else a
        sum.
        """
        if self._braces_hold_name():
            return self._named()
        start = self._position()
        _, inner = self._group()
        if not inner and self.peek() == "^":  # {}^N
            return self._framed()
        return replace(self._read_all(inner), start=start, end=self._end())

    def _command(self, word: str, start: int) -> Node:
        if word in ("frac", "dfrac", "tfrac", "cfrac"):
            self.take()
            return self._fraction(start)
        if word == "sqrt":
            return self._root(start)
        function = self._function_word()
        if function and word in _UPRIGHT:
            self.take()
            self._group()
            return self._call(FUNCTIONS[function], start)
        if word == "arctan" and self.peek(1) == "2" and self.peek(2) in _OPEN:
            mark = self.at
            self.at += 2
            bracket = self._bracket()
            if isinstance(bracket, Bracket) and len(bracket.parts) == 2:
                return FunctionCall(start, self._end(), "atan2", bracket.parts)
            self.at = mark
        if word in FUNCTIONS:
            self.take()
            return self._call(FUNCTIONS[word], start)
        if word == "begin":
            return self._environment(start)
        if word == "sum":
            return self._indexed_sum()
        if word in ("underbrace", "overbrace"):
            return self._annotated()
        if word in ("partial", "int", "iint", "oint", "prod", "lim", "nabla"):
            self.fail(f"\\{word} is not read here")
        if word in ("circ", "degree"):
            self.take()
            return Constant(start, self._end(), "degree")
        if word in GREEK or word in DOTS or word in ACCENTS or word in FONTS:
            return self._named()
        return self.fail(f"\\{word} is not known")

    def _indexed_sum(self) -> Node:
        """Read a sum over an index between whole numbers as the sum of its terms: of the factors
        that follow it.

        Copies of a term stand at the place of the one that is printed.
        """
        start = self.take("\\sum").start
        bounds: dict[str, list[str]] = {"_": [], "^": []}
        while self.peek() in bounds:
            place = self.take().text
            bounds[place] = [token.text for token in self._group()[1]]
        index, *first = bounds["_"] or [""]
        last = bounds["^"]
        if not (
            index.isalpha()
            and first[:1] == ["="]
            and all(map(str.isdigit, (*first[1:], *last)))
            and last
        ):
            self.fail("a sum is read over an index between whole numbers only")
        values = range(int("".join(first[1:]) or -1), int("".join(last)) + 1)
        if not 0 < len(values) <= _MOST_TERMS or values.start < 0:
            self.fail(f"a sum is read of 1 to {_MOST_TERMS} terms only")
        mark = self.at
        self.term()
        body = self.tokens[mark : self.at]
        if index not in (token.text for token in body):
            self.fail(f"the index {index} does not stand in what the sum is of")
        for token in self.tokens[self.at :]:
            if token.text in RELATIONS or token.text == "\\sum":
                break
            if token.text == index:
                self.fail(f"the index {index} stands after the first term too: add brackets")
        copies = (_put_index(body, index, value) for value in values)
        terms = tuple((1, self._read_all(copy, Reader.term)) for copy in copies)
        return build_sum(start, terms, self._end())

    def _annotated(self) -> Node:
        """Read what has a brace over or under it, with or without a remark there."""
        mark = self.at
        remark = "_" if self.take().text == "\\underbrace" else "^"
        node = self._read_all(self._group()[1])
        if self.peek() == remark:
            self.take()
            self._group()
        self._check_braced(node, mark)
        return node

    def _function_word(self) -> str:
        """Return the function that stands in the group after the next token, empty if none does."""
        if self.peek(1) != "{":
            return ""
        word, ahead = "", 2
        while (text := self.peek(ahead)) and text != "}":
            word += text
            ahead += 1
        return word if word in FUNCTIONS else ""

    def _root(self, start: int) -> Node:
        self.take()
        degree: Node = Number(start, start, Fraction(2))
        if self.peek() == "[":
            self.take()
            degree = self.sum()
            self.take("]")
        _, inner = self._group()
        if not isinstance(degree, Number) or degree.value.denominator != 1 or degree.value < 1:
            self.fail("the degree of a root must be a whole number")
        exponent = Number(start, start, 1 / degree.value)
        return Power(start, self._end(), self._read_all(inner), exponent)

    def _fraction(self, start: int) -> Node:
        _, above = self._group()
        _, below = self._group()
        derivative = self._derivative(above, below, start)
        return derivative or Quotient(
            start, self._end(), self._read_all(above), self._read_all(below)
        )

    def _derivative(self, above: list[Token], below: list[Token], start: int) -> Node | None:
        """Read d/dt and partial derivatives, of what stands in the fraction or after it."""
        seen_from, above = _observer(above)
        upper, lower = _without_fonts(above), _without_fonts(below)
        if (
            not upper
            or not lower
            or upper[0].text != lower[0].text
            or upper[0].text not in ("d", "\\partial")
        ):
            return None
        upper, order = _order(upper[1:])
        partial = lower[0].text == "\\partial"
        reader = Reader(self.latex, lower[1:])
        by = reader.try_symbol()
        if by is None:
            return None
        order_below = 1
        if reader.peek() == "^":
            reader.take()
            _, digits = reader._group()
            order_below = (
                int(digits[0].text) if len(digits) == 1 and digits[0].text.isdigit() else 0
            )
        if reader.peek() or order_below != order:
            self.fail("a derivative of mixed kind is not read")
        is_total = not partial and by != Symbol("t")
        if is_total and order > 1:
            self.fail("a total derivative of higher order is read to time t only")
        if upper and not partial and upper[0].text in ("_", "^"):
            return None
        inner = self._read_all(upper) if upper else self.factor()
        return Derivative(
            start,
            self._end(),
            inner,
            order,
            by if partial or is_total else None,
            seen_from,
            is_total,
        )

    def _call(self, function: str, start: int) -> Node:
        """Read a function with what it is of: in brackets, in braces, or juxtaposed factors."""
        exponent: Node | None = None
        while self.peek() in ("^", "_"):
            if self.take().text == "_":
                self.fail("a function with an index is not read")
            _, inner = self._group()
            exponent = self._read_all(inner)
        match exponent:
            case Sum(terms=((-1, Number(value=Fraction(numerator=1, denominator=1))),)):
                if function not in INVERSE:
                    self.fail(f"the power -1 of {function} is not read")
                function, exponent = INVERSE[function], None
        if self.peek() in _OPEN:
            bracket = self._bracket()
            assert isinstance(bracket, Bracket)
            return FunctionCall(start, self._end(), function, bracket.parts, exponent=exponent)
        if self.peek() == "{" and not self._braces_hold_name():
            _, inner = self._group()
            return FunctionCall(
                start, self._end(), function, (self._read_all(inner),), exponent=exponent
            )
        negative = self.peek() == "-" and bool(self.take())
        factors: list[tuple[str, Node]] = []
        while self._begins_factor() and not self._begins_function():
            if factors and (self.peek() in _OPEN or self.peek() in _BARS):
                break
            factors.append(("", self.factor()))
            if self.peek() == "/" and self.peek(1).isdigit():
                self.take()
                below = self.factor()
                factors[-1] = "", Quotient(factors[-1][1].start, self._end(), factors[-1][1], below)
        if not factors:
            self.fail(f"{function} lacks its argument")
        return FunctionCall(start, self._end(), function, (), tuple(factors), negative, exponent)

    def _braces_hold_name(self) -> bool:
        with self._looking_ahead():
            _, inner = self._group()
        return self._read_name(inner) is not None

    def _begins_function(self) -> bool:
        word = self.peek()[1:].rstrip("*")
        return self.peek().startswith("\\") and (
            word in FUNCTIONS or (bool(self._function_word()) and word in FONTS)
        )

    def _environment(self, start: int) -> Node:
        if self.take("\\begin").fixed:
            self.fail("a matrix inside a macro is not read")
        name = self._plain_word()
        if name.rstrip("*") == "array" and self.peek() == "{":
            self._group()
        first = self._position()
        body = self._take_nested("\\begin", "\\end")
        stop = self.tokens[self.at - 1].start
        self._plain_word()
        kind = name.rstrip("*")
        if kind != "cases" and kind not in MATRICES:
            self.fail(f"the environment {name} is not read in a formula")
        lines = self._cells(first, stop, body)
        if kind == "cases":
            return Cases(start, self._end(), tuple(self._case(cells) for cells in lines))
        rows = tuple(tuple(self._read_all(cell) for cell in cells) for cells in lines)
        if len({len(row) for row in rows}) != 1:
            self.fail("rows of a matrix of different lengths")
        return Matrix(start, self._end(), rows, MATRICES[kind])

    def _plain_word(self) -> str:
        _, inner = self._group()
        return "".join(token.text for token in inner)

    def _cells(self, start: int, stop: int, body: list[Token]) -> list[list[list[Token]]]:
        """Return the tokens of an environment by line and column.

        The marks between them are no tokens, so that they are looked for in the source.
        """
        marks = []
        depth = 0
        for match in re.compile(
            r"\\begin|\\end|\\\\\*?(?:\s*\[[^\]]*\])?|\\cr(?![A-Za-z])|\\.|&|[{}]", re.S
        ).finditer(self.latex, start, stop):
            text = match.group()
            depth += {"\\begin": 1, "\\end": -1, "{": 1, "}": -1}.get(text, 0)
            if depth == 0 and (text == "&" or text.startswith(("\\\\", "\\cr"))):
                marks.append((match.start(), match.end(), text == "&"))
        lines: list[list[list[Token]]] = [[]]
        position = start
        for begin, end, is_column in (*marks, (stop, stop, True)):
            lines[-1].append([token for token in body if position <= token.start < begin])
            position = end
            if not is_column:
                lines.append([])
        return [line for line in lines if any(line)]

    def _case(self, cells: list[list[Token]]) -> tuple[Node, RelationChain | None]:
        value = self._read_all(_strip_marks(cells[0]))
        reader = Reader(self.latex, [token for cell in cells[1:] for token in cell])
        condition: list[Token] = []
        while text := reader.peek():
            if text[1:] not in FONTS or reader.peek(1) != "{":
                condition.append(reader.take())
                continue
            reader.take()
            word = reader._plain_word()
            if word.strip(",") not in CONDITION_WORDS:
                self.fail(f"the condition {word} is not read")
        condition = _strip_marks(condition)
        return value, Reader(self.latex, condition).chain() if condition else None

    def try_symbol(self) -> Symbol | None:
        """Return the name that stands next, None if none does; then nothing is taken."""
        mark, tokens = self.at, list(self.tokens)
        try:
            return self._symbol()
        except FormulaError:
            self.at, self.tokens = mark, tokens
            return None

    def _named(self) -> Node:
        start = self._position()
        symbol = self._symbol()
        if symbol == Symbol("\\pi"):
            return Constant(start, self._end(), "pi")
        name = Name(start, self._end(), symbol)
        return self._of_time(name)

    def _of_time(self, named: Name | Power) -> Node:
        """Read what may follow a name or its power: (t), as it depends on time; a value at a time
        is refused.
        """
        if self.peek() == "(" and self.peek(2) == ")" and self.tokens[self.at].start == named.end:
            if self.peek(1) == "t":
                self.at += 3
                return replace(named, end=self._end())
            if self.peek(1).isdigit():
                self.fail("a value at a time is not read")
        return named

    def _symbol(self) -> Symbol:
        """Read nucleus, accents, subscript and primes of a name."""
        token = self.take()
        text = token.text
        word = text[1:] if text.startswith("\\") else ""
        if word in DOTS or word in ACCENTS:
            inner_symbol = self._read_name(self._group()[1])
            if inner_symbol is None:
                self.at -= 1
                self.fail(f"\\{word} over more than a name is not read")
            symbol = inner_symbol
            if word in DOTS:
                symbol = replace(symbol, dots=symbol.dots + DOTS[word])
            else:
                symbol = replace(symbol, accents=(word, *symbol.accents))
        elif word in FONTS:
            inner = self._switched() if word in ("rm", "it", "sf") else self._group()[1]
            stem = "".join(t.text for t in inner)
            if not re.fullmatch(r"\\?[A-Za-z][A-Za-z0-9]*", stem):
                self.at -= 1
                self.fail(f"the text {stem} is no name")
            symbol = Symbol(stem)
        elif text == "{":
            self.at -= 1
            braced = self._read_name(self._group()[1])
            if braced is None:
                self.fail("a group that is no name")
            symbol = braced
        elif word in GREEK or (len(text) == 1 and text.isalpha() and text.isascii()):
            symbol = Symbol(text)
        else:
            self.at -= 1
            self.fail(f"{text} is no name")
        return self._scripts(symbol)

    def _switched(self) -> list[Token]:
        """Return all letters after a switch of the font, as in {\\rm in}."""
        letters: list[Token] = []
        while self.peek().isalnum():
            letters.append(self.take())
        return letters

    def _scripts(self, symbol: Symbol) -> Symbol:
        while True:
            text = self.peek()
            if text == "_" and not symbol.subscript:
                self.take()
                symbol = replace(symbol, subscript=self._spell_group())
            elif text and set(text) == {"'"}:
                symbol = replace(symbol, primes=symbol.primes + len(self.take().text))
            elif text == "^" and self._superscript_is_name(symbol):
                self.take()
                script = self._spell_group()
                if set(script.replace(" ", "")) == {"'"} or re.fullmatch(r"(\\prime ?)+", script):
                    symbol = replace(
                        symbol, primes=symbol.primes + (script.count("prime") or len(script))
                    )
                else:
                    symbol = replace(symbol, after=script)
            else:
                return symbol

    def _superscript_is_name(self, symbol: Symbol) -> bool:
        """Return whether a superscript belongs to a name: primes, a star, text, or the frame of a
        vector.
        """
        with self._looking_ahead():
            self.take()
            try:
                _, inner = self._group()
            except FormulaError:
                return False
        texts = [token.text for token in inner]
        joined = "".join(texts)
        if not joined or symbol.after:
            return False
        if re.fullmatch(r"(\\prime)+|\*|\\ast|\\star|\+|-", joined):
            return True
        if re.fullmatch(r"\([A-Za-z0-9]+\)|\\(?:mathrm|text|textrm|rm)\{?[A-Za-z]{2,}\}?", joined):
            return True
        is_power = _transposes(texts) or re.fullmatch(r"-?\d+|\\circ", joined)
        return symbol.is_vector and not is_power

    def _is_frame_before(self) -> bool:
        """Return whether a ``^`` begins a frame that stands before a vector, as in ^N omega^C, and
        no power.
        """
        with self._looking_ahead(), suppress(FormulaError):
            self.take("^")
            self._group()
            if self.peek().startswith("\\") and self.peek()[1:] in VECTOR_ACCENTS:
                return (symbol := self._symbol()).is_vector and bool(symbol.after)
        return False

    def _framed(self) -> Node:
        start = self.take("^").start
        before = self._spell_group()
        symbol = self._symbol()
        after = self.peek(2) if (self.peek(1), self.peek(3)) == ("{", "}") else self.peek(1)
        if (
            self.peek() == "^" and not symbol.after and re.fullmatch(r"[A-Z]", after)
        ):  # ^N omega^C, not bold
            self.take()
            symbol = replace(symbol, after=self._spell_group())
        return Name(start, self._end(), replace(symbol, before=before))


def _strip_marks(tokens: list[Token]) -> list[Token]:
    """Return tokens without the commas and full stops at their end."""
    tokens = list(tokens)
    while tokens and tokens[-1].text in (",", ";", "."):
        tokens.pop()
    return tokens


def _transposes(texts: list[str]) -> bool:
    fonts = ("\\mathrm", "\\text", "\\mathsf", "\\rm", "{", "}")
    return "".join(text for text in texts if text not in fonts) in ("T", "\\top", "\\intercal")


def _observer(tokens: list[Token]) -> tuple[str, list[Token]]:
    """Return the frame before the d of a derivative, as in ^N d, empty if there is none, and what
    follows it.
    """
    texts = " ".join(token.text for token in tokens)
    frame = (
        r"(?:(?P<a>[A-Za-z])|\{ (?P<b>[A-Za-z]) \}|(?:\{ )?\\(?:mathbf|mathrm|text) \{ "
        r"(?P<c>[A-Za-z]) \}(?: \})?)"
    )
    match = re.match(rf"(?:\{{ \}} )?\^ {frame} (?=d(?: |$))", texts)
    if match is None:
        return "", tokens
    return match["a"] or match["b"] or match["c"], tokens[match.group().count(" ") :]


def _put_index(tokens: list[Token], index: str, value: int) -> list[Token]:
    """Return the tokens of a term of a sum, with a number for its index but in words set
    upright.
    """
    put: list[Token] = []
    depth, is_word = 0, False
    for before, token in zip([None, *tokens], tokens, strict=False):
        if depth or (before is not None and before.text[1:] in FONTS and token.text == "{"):
            depth += {"{": 1, "}": -1}.get(token.text, 0)
            is_word = depth > 0
        if token.text != index or is_word:
            put.append(token)
            continue
        put += [Token(text, token.start, token.end, fixed=True) for text in ("{", str(value), "}")]
    return put


def _without_fonts(tokens: list[Token]) -> list[Token]:
    """Return the tokens of a differential with an upright d as a plain one."""
    texts = [token.text for token in tokens]
    for font in ("\\mathrm", "\\text", "\\mathit"):
        if texts[:4] == [font, "{", "d", "}"]:
            return [tokens[2], *tokens[4:]]
        if texts[:2] == [font, "d"]:
            return tokens[1:]
    return tokens[1:] if texts[:2] == ["\\rm", "d"] else tokens


def _order(tokens: list[Token]) -> tuple[list[Token], int]:
    """Return what follows the order of a derivative, and the order."""
    if len(tokens) > 1 and tokens[0].text == "^":
        if tokens[1].text.isdigit():
            return tokens[2:], int(tokens[1].text)
        if len(tokens) > 3 and tokens[1].text == "{" and tokens[2].text.isdigit():
            return tokens[4:], int(tokens[2].text)
    return tokens, 1


def read_formula(
    latex: str,
    macros: Mapping[str, tuple[int, str]] | None = None,
    brackets: dict[tuple[str, ...], Bracket] | None = None,
) -> RelationChain:
    """Read a formula as a tree.

    Raises FormulaError, which says at which place, for what is not read for certain.

    ``brackets`` are those of formulas like it, which are read once and added to.
    """
    reader = Reader(latex, tokenize_formula(latex, macros), brackets=brackets)
    chain = reader.chain()
    if not chain.relations:
        raise FormulaError("no relation stands in it: it states nothing")
    return chain


def read_terms(
    latex: str, macros: Mapping[str, tuple[int, str]], brackets: dict[tuple[str, ...], Bracket]
) -> tuple[tuple[int, Node], ...]:
    """Read a sum as its signs and terms.

    Raises FormulaError; ``brackets`` are those of `read_formula`.
    """
    reader = Reader(latex, tokenize_formula(latex, macros), brackets=brackets)
    terms = reader.terms()
    reader.finish()
    return terms


def build_sum(start: int, terms: tuple[tuple[int, Node], ...], end: int) -> Node:
    """Return the sum of terms, a term itself if there is but one, with a plus."""
    return terms[0][1] if len(terms) == 1 and terms[0][0] == 1 else Sum(start, end, terms)


def list_nodes(node: Node) -> Iterator[Node]:
    """Yield a node and all below it."""
    yield node
    for part in vars(node).values():
        yield from _nodes_in(part)


def _nodes_in(part: object) -> Iterator[Node]:
    if isinstance(part, Node):
        yield from list_nodes(part)
    elif isinstance(part, tuple):
        for entry in part:
            yield from _nodes_in(entry)
