"""Check verdicts on printed equations without planter and without derive:
python check_verdicts.py FILE.

Trusted are the transcriptions, the meanings that readings give to symbols, the derivations and the
definitions of derived quantities. Everything else is repeated: that readings lead from a
transcription to what was judged, that each correction is one replacement and is needed, that print,
corrections and missing terms are the derivation, that a term which is called missing stands in the
print under no reading, and that a print which is called wrong fails at its witness point. Equality
is exact: of rational functions of the quantities and of sines and cosines with c2 + s2 = 1. Where
other functions remain, it is tried with error bounds at 40 random rational points. Needs the
standard library and python-flint. Exit code 1 if a verdict does not follow, 2 for a file that is
none; the last line is `valid`, or names the first such verdict.
"""

from __future__ import annotations

import ast
import json
import operator
import random
import re
import sys
from collections import Counter
from fractions import Fraction
from functools import cache, reduce
from pathlib import Path

from flint import arb, ctx, fmpq, fmpq_mpoly_ctx

SAMPLES, TRIES, PLACE, MOST_WORDS, BITS = 40, 4000, "_place", 4, 400
SMALL, CLOSE = arb(10) ** -60, arb(10) ** -20
"""What is left of terms of size one where two sides are equal, far above rounding at so many bits;
and where values are given to 30 digits.
"""
OPERATORS = {ast.Add: operator.add, ast.Sub: lambda a, b: a + -b, ast.Mult: operator.mul}
OPERATORS |= {ast.Div: lambda a, b: a * b**-1, ast.BitAnd: operator.and_, ast.BitOr: operator.or_}
RELATIONS = {"<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge}
SIGNS = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">="}
NAMES = "sin cos tan cot sec csc asin acos atan atan2 sinh cosh tanh exp log sqrt floor"
FUNCTIONS = {name: getattr(arb, name) for name in NAMES.split()}
FUNCTIONS |= {"Abs": abs, "Min": arb.min, "Max": arb.max, "sign": arb.sgn, "**": operator.pow}


class RefusalError(ValueError):
    """A verdict does not follow from what the file states."""


class UndecidedError(ArithmeticError):
    """An expression has no real value at a point, or a condition cannot be decided there."""


FAILURES = LookupError, ValueError, TypeError, ArithmeticError, SyntaxError, AttributeError, OSError


def _demand(condition, complaint):
    """Raise RefusalError with a complaint unless a condition holds."""
    if not condition:
        raise RefusalError(complaint)


def _number(text):
    """Return the fraction that a decimal number is."""
    return fmpq(*Fraction(text).as_integer_ratio())


@cache
def _parse(text):
    """Return the syntax tree of a formula."""
    return ast.parse(text, mode="eval").body


def names_in(*texts):
    """Return the names of quantities in formulas, each as often as it stands there."""
    names = [n.id for t in texts for n in ast.walk(_parse(t)) if isinstance(n, ast.Name)]
    return [name for name in names if name not in (*FUNCTIONS, "Piecewise", "pi")]


def _replace(text, meanings):
    """Return a formula with names replaced by formulas, all at once."""
    meanings = {name: f"({meant})" for name, meant in meanings.items()}
    return re.sub(r"\b[A-Za-z_]\w*", lambda word: meanings.get(word[0], word[0]), text)


def evaluate_in(node, algebra):
    """Return the value of a formula in an algebra: numbers at a point, or rational functions."""
    node = _parse(node) if isinstance(node, str) else node
    if isinstance(node, ast.Constant):
        return node.value if node.value is True else algebra.number(_number(str(node.value)))
    if isinstance(node, ast.Name):
        return algebra.symbol(node.id)
    if isinstance(node, ast.UnaryOp):
        value = evaluate_in(node.operand, algebra)
        return -value if isinstance(node.op, ast.USub) else not value
    if isinstance(node, ast.Call):
        return algebra.call(node.func.id, node)
    compared = node.comparators[0] if isinstance(node, ast.Compare) else node.right
    left, right = evaluate_in(node.left, algebra), evaluate_in(compared, algebra)
    if isinstance(node, ast.Compare):
        return algebra.holds(SIGNS[type(node.ops[0])], left + -right)
    if isinstance(node.op, ast.Pow):
        is_whole = (exponent := ast.unparse(compared)).removeprefix("-").isdigit()
        return left ** int(exponent) if is_whole else algebra.call("**", node)
    return OPERATORS[type(node.op)](left, right)


class Numbers(dict):
    """Numbers with error bounds, at a point."""

    number = arb

    def symbol(self, name):
        """Return the value of a quantity."""
        return arb.pi() if name == "pi" else arb(self[name])

    def call(self, name, node):
        """Return the value of a function; of one with cases, that of the first that holds."""
        if name == "Piecewise":
            chosen = (p.elts[0] for p in node.args if evaluate_in(p.elts[1], self))
            return evaluate_in(next(chosen, "0"), self)
        parts = (node.left, node.right) if name == "**" else node.args
        return FUNCTIONS[name](*(evaluate_in(part, self) for part in parts))

    def holds(self, sign, gap):
        """Return whether a difference has a sign; raises UndecidedError if it may be zero."""
        if not gap.is_finite() or gap.contains(0):
            raise UndecidedError
        return bool(RELATIONS[sign](gap, 0))


def value_at(text, point):
    """Return the value of a formula at a point; raises UndecidedError where it has none."""
    value = evaluate_in(text, Numbers(point))
    if not value.is_finite():
        raise UndecidedError
    return value


class RingFraction:
    """A rational function: numerator and denominator in a ring."""

    def __init__(self, ring, above, below):
        self.ring, above, below = ring, ring.reduce(above), ring.reduce(below)
        common = below.leading_coefficient() if below.is_constant() else above.gcd(below)
        self.above, self.below = above / common, below / common

    def __add__(self, other):
        above = self.above * other.below + other.above * self.below
        return RingFraction(self.ring, above, self.below * other.below)

    def __mul__(self, other):
        return RingFraction(self.ring, self.above * other.above, self.below * other.below)

    def __neg__(self):
        return RingFraction(self.ring, -self.above, self.below)

    def __pow__(self, exponent):
        above, below = (self.above, self.below)[:: 1 if exponent >= 0 else -1]
        return RingFraction(self.ring, above ** abs(exponent), below ** abs(exponent))


class Ring:
    """Rational functions of symbols, of cosine and sine of each angle, and of other functions as
    they stand.
    """

    def __init__(self, *texts):
        size = 3 * sum(1 for text in texts for _ in ast.walk(_parse(text)))
        self.polynomials = fmpq_mpoly_ctx.get(("x", min(size, 600)), "degrevlex")
        self.unit, self.generators, self.circles = self.polynomials.constant(1), {}, {}

    def generator(self, key):
        """Return the variable that stands for a key."""
        return self.polynomials.gen(self.generators.setdefault(key, len(self.generators)))

    def number(self, value):
        """Return a number of the ring."""
        return RingFraction(self, self.unit * value, self.unit)

    def symbol(self, name):
        """Return a quantity, or what stands for a function of some."""
        return RingFraction(self, self.generator(name), self.unit)

    def call(self, name, node):
        """Return sine, cosine or tangent of an angle; another function stands for itself."""
        if name not in ("sin", "cos", "tan"):
            return self.symbol(ast.unparse(node))
        c, s = (
            RingFraction(self, part, self.unit)
            for part in self.turn(evaluate_in(node.args[0], self))
        )
        return {"sin": s, "cos": c}.get(name) or s * c**-1

    def turn(self, angle):
        """Return cosine and sine of an angle, by those of its terms."""
        if not angle.below.is_constant():
            return self.circle(f"{angle.above} / {angle.below}", fmpq(1))
        c, s = self.unit, 0 * self.unit
        for powers, value in angle.above.to_dict().items():
            a, b = self.circle(powers, value)
            c, s = c * a - s * b, s * a + c * b
        return c, s

    def circle(self, key, value):
        """Return cosine and sine of a multiple of an angle."""
        cosine, sine = (self.generator((key, str(value.q), kind)) for kind in ("cos", "sin"))
        self.circles[self.generators[key, str(value.q), "sin"]] = cosine
        c, s = self.unit, 0 * self.unit
        for _ in range(abs(int(value.p))):
            c, s = c * cosine - s * sine, s * cosine + c * sine
        return c, s if value > 0 else -s

    def reduce(self, polynomial):
        """Replace squares of sines by those of cosines."""
        high = [(p, c) for p, c in self.circles.items() if polynomial.degrees()[p] > 1]
        for place, cosine in high:
            parts = {}
            for powers, value in polynomial.to_dict().items():
                rest = (*powers[:place], powers[place] % 2, *powers[place + 1 :])
                parts.setdefault(powers[place] // 2, {})[rest] = value
            terms = (self.polynomials.from_dict(p) * (1 - cosine**2) ** n for n, p in parts.items())
            polynomial = sum(terms, 0 * self.unit)
        return polynomial


def _wrap(gap, entry):
    """Return a difference without whole turns, if it is one of directions."""
    turn = 2 * arb.pi()
    return gap - turn * ((gap / turn + fmpq(1, 2)).mid().floor() if entry["direction"] else 0)


def draw_points(entry, names):
    """Yield the points of use of an entry, else random rational points of its ranges."""
    yield from ({n: _number(v) for n, v in values.items()} for values in entry["points"])
    source = random.Random(f"{entry['paper']} {entry['equation']}")
    ends = {n: [*map(_number, entry["ranges"].get(n, ("1/5", "11/5")))] for n in names}
    wide = all((high - low) * 1000 > abs(low) + abs(high) for low, high in ends.values())
    _demand(wide or entry["points"], "random points are drawn from more than a point")
    for _ in range(0 if entry["points"] else TRIES):
        shares = {n: fmpq(source.randint(1, 10**6), 10**6) for n in names}
        yield {n: low + (high - low) * shares[n] for n, (low, high) in ends.items()}


def find_equality(first, second, entry):
    """Return how two residuals are basis to be equal after the definitions that an entry names; ""
    if they are not.
    """
    first, second = (_define(text, entry, entry["definitions"]) for text in (first, second))
    gap, where, points = f"{first} - ({second})", entry["where"] or "True", 0
    if not entry["points"] and evaluate_in(gap, Ring(gap)).above == 0:
        return "exactly"
    limit = CLOSE if entry["points"] else SMALL
    for point in draw_points(entry, sorted({*names_in(gap, where)})):
        try:
            if evaluate_in(where, Numbers(point)):
                size = 1 + abs(value_at(first, point)) + abs(value_at(second, point))
                if not abs(_wrap(value_at(gap, point), entry)) < limit * size:
                    return ""
                points += 1
        except ArithmeticError:
            continue
        if points == (len(entry["points"]) or SAMPLES):
            return f"at {points} points" + (" of use" if entry["points"] else "")
    raise RefusalError(f"no {SAMPLES} points at which both sides have values")


def _define(text, entry, names):
    """Return a formula with defined quantities replaced, in the order of the names."""
    return reduce(lambda t, name: _replace(t, {name: entry["table"][name]}), names, text)


def _residual(side, entry):
    """Return what vanishes by a side of an equation."""
    return f"{entry['defines']} - ({side})" if entry["solved"] else side


def find_transcription(entry):
    """Return the residual of a print in its own symbols."""
    return "{} - ({})".format(*entry["transcription"].split(f" {entry['relations'][0]} ", 1))


def check_reading(entry):
    """Readings lead from the transcription to what was judged and corrected."""
    text = _replace(entry["text"] or find_transcription(entry), entry["meanings"])
    plain, factor = {**entry, "direction": False, "points": []}, entry["undivided"]
    text = _define(text, entry, entry["through"])
    _demand(find_equality(text, entry["read"], plain), "readings do not lead to what was judged")
    _demand(not value_at(factor, Counter(names_in(factor))).contains(0), "a multiple of zero")
    start, scaled = _residual(entry["initial"], entry), f"({factor})*({entry['read']})"
    _demand(find_equality(start, scaled, plain), "what was corrected is not what was read")


def _correct(entry, steps):
    """Return the side after corrections, of which each replaces one part, or symbols throughout."""
    side, plain = entry["initial"], {**entry, "direction": False, "definitions": []}
    for step in steps:
        old, new, swaps = step["old"], step["new"], step["swaps"]
        words, readings = (Counter(re.findall(r"\w+", text)) for text in (old, new))
        few = ((words - readings) + (readings - words)).total() <= MOST_WORDS or new == "0"
        _demand(swaps or (few and names_in(step["frame"]).count(PLACE) == 1), "no small change")
        before, after = (_replace(step["frame"], {PLACE: text}) for text in (old, new))
        if swaps:
            before, after = side, _replace(side, swaps)
        same = find_equality(before, side, plain) and find_equality(after, step["after"], plain)
        _demand(same, f"{step['words']!r} is not what was done")
        side = step["after"]
    return side


def check_identity(entry, side):
    """Return how print, corrections and missing less unexplained terms are the derivation."""
    signs = {"missing": "", "unexplained": "-"}
    terms = [f"{sign}({text})" for part, sign in signs.items() for text in entry[part]]
    side = " + ".join([f"({side})", *terms])
    printed, corrected, derived = entry["relations"]
    multiple = value_at(entry["multiple"], {})
    _demand(not multiple.contains(0), "a multiple of zero says nothing")
    _demand(entry["flips"] == (corrected != printed), "the relation is another than was said")
    if derived != "=":
        keeps = multiple * value_at(entry["undivided"], {}) > 0
        sign = corrected if keeps else corrected.translate(str.maketrans("<>", "><"))
        _demand(sign == derived, "the relation is another")
    meant, side = f"({entry['multiple']})*({entry['derived']})", _residual(side, entry)
    _demand(basis := find_equality(side, meant, entry), "all of it is not the derivation")
    return basis


def check_missing(entry, readings, side):
    """Check that what is called missing stands in the print under no reading."""
    names = [*entry["definitions"], *entry["meaning_of_missing"]]
    sums = [" + ".join(["0", *(f"({t})" for t in entry[p])]) for p in ("missing", "unexplained")]
    starts = [e["initial"] for e in (entry, *readings) if e["solved"] == entry["solved"]]
    texts = [_define(text, entry, names) for text in (side, *sums, *starts)]
    ring = Ring(*texts)
    ratios = [evaluate_in(text, ring) for text in texts]
    common = reduce(operator.mul, {str(r.below): r.below for r in ratios}.values())
    sums = [ring.reduce(ratio.above * (common / ratio.below)).to_dict() for ratio in ratios]
    for powers, value in sums[1].items():
        total = sums[0].get(powers, 0) + value - sums[2].get(powers, 0)
        for some in sums[3:]:
            size = some.get(powers, fmpq(0))
            is_one_of_several = size * total > 0 and abs(total) > abs(size) and value * total > 0
            _demand(size == 0 or is_one_of_several, "what is called missing stands in the print")


def check_witness(entry):
    """Print and derivation do not agree at a point, at which the derivation holds by the value of
    an unknown.
    """
    point = {name: _number(value) for name, value in entry["witness"]["values"].items()}
    loose = [value_at(text, point) for text in entry["loose"].values()]
    _demand(not any(value.contains(0) for value in loose), "what must vanish does")
    printed, derived, unknown = entry["read"], entry["derived"], entry["witness"]["unknown"]
    if entry["relations"][0] != "=":
        signs = zip(entry["relations"][::2], (printed, derived), strict=True)
        truths = {Numbers(point).holds(sign, value_at(side, point)) for sign, side in signs}
        _demand(len(truths) == 2, "the conditions agree at the witness point")
    elif not loose:
        at = [value_at(derived, {**point, unknown: fmpq(x)}) for x in (0, 1, 2)]
        _demand((at[2] - 2 * at[1] + at[0]).contains(0), "the derivation is not linear")
        left = value_at(printed, {**point, unknown: at[0] / (at[0] - at[1])})
        _demand(abs(_wrap(left, entry)) > arb(10) ** -40, "the print holds at the witness point")


def _spread(text):
    """Return a printed number with half a unit of its last digit as the error."""
    return arb(_number(text), arb(fmpq(1, 2) / 10 ** len(text.partition(".")[2])))


def check_values(entry):
    """A definition gives the values that the paper prints beside it, to their last digits."""
    for witness in entry["values"]:
        point = {name: _spread(text) for name, text in witness["values"].items()}
        for name, ends in witness["between"].items():
            point[name] = arb.union(*(value_at(text, point) for text in ends))
        gap = value_at(find_transcription(entry), point)
        _demand(gap.contains(0), f"it does not give {witness['where']}")
    return "by their values alone"


def check_entry(entry, readings):
    """Return how a verdict under one reading was checked."""
    verdict, terms = entry["verdict"], (bool(entry["missing"]), bool(entry["unexplained"]))
    if verdict == "reconstructed" or not entry["derived"]:
        is_lost = verdict == "reconstructed" and entry["legibility"] == "lost"
        _demand(is_lost or verdict in ("definition", "untested"), "there is nothing to compare")
        return check_values(entry)
    check_reading(entry)
    corrections, is_condition = entry["steps"] or [[]], entry["relations"][0] != "="
    is_corrected = any(corrections) or entry["flips"]
    if verdict in ("confirmed", "confirmed as rebuilt", "untested"):
        _demand(not (any(terms) or is_corrected), "a sound print needs nothing")
    else:
        _demand(verdict != "misprint" or is_corrected, "nothing was corrected")
        _demand(entry["loose"] or terms in EXPECTED[verdict], "terms of another verdict")
    if verdict in EXPECTED or entry["points"]:
        check_witness(entry)
    if entry["loose"] or (is_condition and verdict == "contradicted"):
        return "at their witness points"
    ways = [check_identity(entry, _correct(entry, steps)) for steps in corrections]
    if readings:
        check_missing(entry, readings, _correct(entry, corrections[0]))
    return max(ways, key=len)


EXPECTED = {"misprint": {(0, 0)}, "incomplete": {(1, 0)}, "contradicted": {(0, 1), (1, 1)}}
"""Whether terms are missing and unexplained, by verdict."""


@ctx.workprec(BITS)
def check_record(record, tables):
    """Return how the verdict on an equation was checked, under every reading."""
    entries = [record | {"table": tables[record["paper"]]} | r for r in record["readings"]]
    taken = entries[record["taken"]]
    _demand(record["verdict"] == taken["verdict"], "the verdict is that of another reading")
    basis = [check_entry(entry, entries if entry is taken else ()) for entry in entries]
    _demand(record["statement"] == describe_verdict(record), "statement of something else")
    return basis[record["taken"]]


def describe_verdict(record):
    """Return a verdict in words, made of what is checked of it."""
    parts = [record["verdict"]]
    for reading in record["readings"][record.get("taken", 0) :][:1]:
        words = [step["words"] for steps in reading["steps"][:1] for step in steps]
        words[:0] = ["{1} for {0}".format(*reading["relations"])] if reading["flips"] else []
        parts += [f"corrected, {'; '.join(words)}"] if words else []
        parts += [f"it lacks {', '.join(reading['missing'])}"] if reading["missing"] else []
        parts += ["where the machine uses it, and not everywhere"] if reading["points"] else []
    return ": ".join([parts[0], "; ".join(parts[1:])]) if parts[1:] else parts[0]


def main(arguments):
    """Check a file of verdicts, and return the exit code."""
    counts, record = Counter(), {}
    try:
        document = json.loads(Path(*arguments).read_text(encoding="utf-8"))
        for record in document["records"]:
            counts[check_record(record, document["definitions"])] += 1
    except FAILURES as error:
        print(f"{record.get('paper', 'no file')} {record.get('equation', '')}: {error!r}")
        return 1 if record else 2
    print(*(f"{n} verdicts checked {how}" for how, n in counts.items()), "valid", sep="\n")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
