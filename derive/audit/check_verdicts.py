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
import sys
from collections import Counter
from fractions import Fraction
from functools import cache, reduce
from pathlib import Path

from flint import arb, ctx, fmpq, fmpq_mpoly_ctx

SAMPLES, TRIES, PLACE = 40, 4000, "_place"
ctx.prec = 400
SMALL = arb(10) ** -60
"""What is left of terms of size one where two sides are equal, far above rounding at 400 bits."""
CLOSE = arb(10) ** -20
"""The same where values are given to 30 digits."""
SYMBOLS = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.BitAnd: "&", ast.BitOr: "|"}
OPERATORS = {"+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv}
OPERATORS |= {"&": operator.and_, "|": operator.or_}
RELATIONS = {"<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge}
SIGNS = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">="}
FLIPPED = {"=": "=", "<": ">", ">": "<", "<=": ">=", ">=": "<="}
NAMES = "sin cos tan cot sec csc asin acos atan atan2 sinh cosh tanh exp log sqrt floor"
FUNCTIONS = {name: getattr(arb, name) for name in NAMES.split()}
FUNCTIONS |= {"Abs": abs, "Min": arb.min, "Max": arb.max, "sign": arb.sgn}
COMMON = ["paper", "equation", "legibility", "transcription", "defines", "direction", "values"]
NOT_LOST, NO_TERM = "the print is not lost", "no term is left over, or one that may not be"


class RefusedError(Exception):
    """A verdict does not follow from what the file states."""


class UndecidedError(Exception):
    """An expression has no real value at a point, or a condition cannot be decided there."""


FAILURES = RefusedError, UndecidedError, LookupError, ValueError, TypeError, ArithmeticError


def demand(condition, what):
    """Raise RefusedError with what is wrong unless a condition holds."""
    if not condition:
        raise RefusedError(what)


@cache
def parse(text):
    return ast.parse(text, mode="eval").body


def number(text):
    return fmpq(*Fraction(text).as_integer_ratio())


def difference(first, second):
    return ast.BinOp(first, ast.Sub(), second)


class Meanings(ast.NodeTransformer):
    """Replaces names by expressions, all at once."""

    def __init__(self, meanings):
        self.meanings = meanings

    def visit_Name(self, node):
        return self.meanings.get(node.id, node)


def substitute(tree, meanings):
    return Meanings(meanings).visit(ast.parse(ast.unparse(tree), mode="eval").body)


def names_in(tree):
    return [node.id for node in ast.walk(tree) if isinstance(node, ast.Name)]


def evaluate(node, algebra):
    """Return the value of an expression in an algebra: numbers at a point, or rational functions."""
    if isinstance(node, ast.Constant):
        return node.value if node.value is True else algebra.number(number(str(node.value)))
    if isinstance(node, ast.Name):
        return algebra.symbol(node.id)
    if isinstance(node, ast.UnaryOp):
        value = evaluate(node.operand, algebra)
        return -value if isinstance(node.op, ast.USub) else not value
    if isinstance(node, ast.Compare):
        gap = evaluate(difference(node.left, node.comparators[0]), algebra)
        return algebra.holds(SIGNS[type(node.ops[0])], gap)
    if isinstance(node, ast.Call):
        return algebra.call(node.func.id, node)
    if isinstance(node.op, ast.Pow):
        base, exponent = evaluate(node.left, algebra), ast.unparse(node.right)
        whole = exponent.removeprefix("-").isdigit()
        return base ** int(exponent) if whole else algebra.power(base, node)
    left, right = evaluate(node.left, algebra), evaluate(node.right, algebra)
    return OPERATORS[SYMBOLS[type(node.op)]](left, right)


class Numbers:
    """Numbers with error bounds, at a point."""

    number = arb

    def __init__(self, point):
        self.point = point

    def symbol(self, name):
        return arb.pi() if name == "pi" else arb(self.point[name])

    def power(self, base, node):
        return base ** evaluate(node.right, self)

    def call(self, name, node):
        if name == "Piecewise":
            chosen = (p.elts[0] for p in node.args if evaluate(p.elts[1], self))
            return evaluate(next(chosen, ast.Constant(0)), self)
        return FUNCTIONS[name](*(evaluate(part, self) for part in node.args))

    def holds(self, sign, gap):
        if not gap.is_finite() or gap.contains(0):
            raise UndecidedError
        return bool(RELATIONS[sign](gap, 0))


def value_at(tree, point):
    """Return the value of an expression at a point; raises UndecidedError where it has none."""
    value = evaluate(tree, Numbers(point))
    if not value.is_finite():
        raise UndecidedError
    return value


class Ratio:
    """A rational function: numerator and denominator in a ring."""

    def __init__(self, ring, above, below):
        self.ring, above, below = ring, ring.reduce(above), ring.reduce(below)
        common = below.leading_coefficient() if below.is_constant() else above.gcd(below)
        self.above, self.below = above / common, below / common

    def __add__(self, other):
        above = self.above * other.below + other.above * self.below
        return Ratio(self.ring, above, self.below * other.below)

    def __mul__(self, other):
        return Ratio(self.ring, self.above * other.above, self.below * other.below)

    def __truediv__(self, other):
        return Ratio(self.ring, self.above * other.below, self.below * other.above)

    def __neg__(self):
        return Ratio(self.ring, -self.above, self.below)

    def __sub__(self, other):
        return self + -other

    def __pow__(self, exponent):
        above, below = (self.above, self.below)[:: 1 if exponent >= 0 else -1]
        return Ratio(self.ring, above ** abs(exponent), below ** abs(exponent))


class Ring:
    """Rational functions of symbols, of cosine and sine of each angle, and of other functions as
    they stand, where these are not refused.
    """

    def __init__(self, trees, is_strict):
        size = 3 * sum(1 for tree in trees for _ in ast.walk(tree))
        self.polynomials = fmpq_mpoly_ctx.get(("x", min(size, 600)), "degrevlex")
        self.free, self.generators = list(range(len(self.polynomials.gens()))), {}
        self.one, self.is_strict, self.circles = self.polynomials.constant(1), is_strict, {}

    def generator(self, key):
        if key not in self.generators:
            self.generators[key] = self.free.pop(0)
        return self.polynomials.gen(self.generators[key])

    def number(self, value):
        return Ratio(self, self.one * value, self.one)

    def symbol(self, name):
        return Ratio(self, self.generator(name), self.one)

    def power(self, base, node):
        return self.opaque(node)

    def opaque(self, node):
        if self.is_strict:
            raise UndecidedError
        return self.symbol(ast.unparse(node))

    def call(self, name, node):
        if name not in ("sin", "cos", "tan"):
            return self.opaque(node)
        c, s = (Ratio(self, part, self.one) for part in self.turn(evaluate(node.args[0], self)))
        return {"sin": s, "cos": c, "tan": s / c if name == "tan" else None}[name]

    def turn(self, angle):
        """Return cosine and sine of an angle, by those of its terms."""
        if not angle.below.is_constant():
            return self.circle(f"{angle.above} / {angle.below}", fmpq(1))
        c, s = self.one, 0 * self.one
        for powers, value in angle.above.to_dict().items():
            a, b = self.circle(powers, value)
            c, s = c * a - s * b, s * a + c * b
        return c, s

    def circle(self, key, value):
        """Return cosine and sine of a multiple of an angle."""
        cosine, sine = (self.generator((key, str(value.q), kind)) for kind in ("cos", "sin"))
        self.circles[self.generators[key, str(value.q), "sin"]] = cosine
        c, s = self.one, 0 * self.one
        for _ in range(abs(int(value.p))):
            c, s = c * cosine - s * sine, s * cosine + c * sine
        return c, s if value > 0 else -s

    def reduce(self, polynomial):
        """Replace squares of sines by those of cosines."""
        for place, cosine in self.circles.items():
            if polynomial.degrees()[place] < 2:
                continue
            parts = {}
            for powers, value in polynomial.to_dict().items():
                rest = (*powers[:place], powers[place] % 2, *powers[place + 1 :])
                parts.setdefault(powers[place] // 2, {})[rest] = value
            terms = (self.polynomials.from_dict(p) * (1 - cosine**2) ** n for n, p in parts.items())
            polynomial = reduce(operator.add, terms)
        return polynomial


def is_zero_exactly(tree):
    """Return whether an expression is zero as a rational function, None if it is none."""
    try:
        return evaluate(tree, Ring([tree], is_strict=True)).above == 0
    except UndecidedError:
        return None


def is_small(value, size, modulus, limit):
    if modulus:
        value -= modulus * (value / modulus + fmpq(1, 2)).mid().floor()
    return bool(abs(value) < limit * size)


def draw_points(entry, names):
    """Yield the points of use of an entry, else random rational points of its ranges."""
    yield from ({n: number(v) for n, v in values.items()} for values in entry["points"])
    source = random.Random(f"{entry['paper']} {entry['equation']}")
    for _ in range(0 if entry["points"] else TRIES):
        ends = {n: map(number, entry["ranges"].get(n, ("1/5", "2"))) for n in names}
        shares = {n: fmpq(source.randint(1, 10**6), 10**6) for n in names}
        yield {n: low + (high - low) * shares[n] for n, (low, high) in ends.items()}


def find_equality(first, second, entry):
    """Return how two residuals are known to be equal after the definitions that an entry names; ""
    if they are not.
    """
    first, second = (define(tree, entry, entry["definitions"]) for tree in (first, second))
    gap, where, points = difference(first, second), parse(entry["where"] or "True"), 0
    if not entry["points"] and is_zero_exactly(gap):
        return "exactly"
    modulus = 2 * arb.pi() if entry["direction"] else None
    limit = CLOSE if entry["points"] else SMALL
    for point in draw_points(entry, sorted({*names_in(gap), *names_in(where)} - {"pi"})):
        try:
            if evaluate(where, Numbers(point)):
                size = 1 + abs(value_at(first, point)) + abs(value_at(second, point))
                if not is_small(value_at(gap, point), size, modulus, limit):
                    return ""
                points += 1
        except (UndecidedError, ZeroDivisionError):
            continue
        except KeyError:
            return ""
        if points == (len(entry["points"]) or SAMPLES):
            return f"at {points} points" + (" of use" if entry["points"] else "")
    raise RefusedError(f"no {SAMPLES} points at which both sides have values")


def define(tree, entry, names):
    """Return an expression with defined quantities replaced, in the order of the names."""
    for name in names:
        tree = substitute(tree, {name: parse(entry["table"][name])})
    return tree


def residual(side, entry):
    return difference(parse(entry["defines"]), side) if entry["solved"] else side


def find_transcription(entry):
    left, _, right = entry["transcription"].partition(f" {entry['relations'][0]} ")
    return difference(parse(left), parse(right))


def check_reading(entry):
    text = parse(entry["text"]) if entry["text"] else find_transcription(entry)
    meanings = {name: parse(meant) for name, meant in entry["meanings"].items()}
    read = define(substitute(text, meanings), entry, entry["through"])
    plain = {**entry, "direction": False, "points": []}
    known = find_equality(read, parse(entry["read"]), plain)
    demand(known, "the readings do not lead to what was judged")
    scaled = ast.BinOp(parse(entry["undivided"]), ast.Mult(), parse(entry["read"]))
    known = find_equality(residual(parse(entry["start"]), entry), scaled, plain)
    demand(known, "what was corrected is not what was read")


def correct(entry, steps):
    """Return the side after corrections, of which each replaces one part, or symbols throughout."""
    side, plain = parse(entry["start"]), {**entry, "direction": False, "definitions": []}
    for step in steps:
        frame, after = parse(step["frame"]), parse(step["after"])
        swaps = {old: parse(new) for old, new in step["swaps"].items()}
        demand(swaps or names_in(frame).count(PLACE) == 1, "a correction is made at one place")
        ways = [substitute(frame, {PLACE: parse(step[part])}) for part in ("old", "new")]
        before, changed = (side, substitute(side, swaps)) if swaps else ways
        same = find_equality(before, side, plain) and find_equality(changed, after, plain)
        demand(same, f"{step['words']!r} is not what was done")
        side = after
    return side


def check_identity(entry, side):
    """Return how print, corrections and missing less unexplained terms are the derivation."""
    for sign, part in ((ast.Add(), "missing"), (ast.Sub(), "unexplained")):
        side = reduce(lambda s, text, sign=sign: ast.BinOp(s, sign, parse(text)), entry[part], side)
    printed, corrected, derived = entry["relations"]
    multiple = value_at(parse(entry["multiple"]), {})
    demand(not multiple.contains(0), "a multiple of zero says nothing")
    demand(entry["flips"] == (corrected != printed), "the relation is another than was said")
    if derived != "=":
        keeps = multiple * value_at(parse(entry["undivided"]), {}) > 0
        demand((corrected if keeps else FLIPPED[corrected]) == derived, "the relation is another")
    meant = ast.BinOp(parse(entry["multiple"]), ast.Mult(), parse(entry["derived"]))
    known = find_equality(residual(side, entry), meant, entry)
    demand(known, "print, corrections and terms are not the derivation")
    return known


def check_missing(entry, others, side):
    """What is called missing stands in the print under no reading."""
    names = [*entry["definitions"], *entry["meaning_of_missing"]]
    add = [" + ".join(["0", *(f"({t})" for t in entry[p])]) for p in ("missing", "unexplained")]
    starts = [e["start"] for e in (entry, *others) if e["solved"] == entry["solved"]]
    trees = [define(tree, entry, names) for tree in (side, *map(parse, (*add, *starts)))]
    ring = Ring(trees, is_strict=False)
    ratios = [evaluate(tree, ring) for tree in trees]
    common = reduce(operator.mul, {str(r.below): r.below for r in ratios}.values())
    corrected, lacking, loose, *prints = (
        ring.reduce(r.above * (common / r.below)).to_dict() for r in ratios
    )
    for powers, value in lacking.items():
        total = corrected.get(powers, 0) + value - loose.get(powers, 0)
        for some in prints:
            here = some.get(powers, fmpq(0))
            is_one_of_several = here * total > 0 and abs(total) > abs(here) and value * total > 0
            demand(here == 0 or is_one_of_several, "what is called missing stands in the print")


def check_witness(entry):
    """Print and derivation do not agree at a point, at which the derivation holds by the value of
    an unknown.
    """
    point = {name: number(value) for name, value in entry["witness"]["values"].items()}
    loose = [value_at(parse(text), point) for text in entry["loose"].values()]
    demand(not any(value.contains(0) for value in loose), "what must vanish does")
    if loose:
        return
    sides, unknown = [parse(entry[key]) for key in ("read", "derived")], entry["witness"]["unknown"]
    if entry["relations"][0] != "=":
        signs = zip(entry["relations"][::2], sides, strict=True)
        truths = {Numbers(point).holds(sign, value_at(side, point)) for sign, side in signs}
        demand(len(truths) == 2, "the conditions agree at the witness point")
        return
    at = [value_at(sides[1], {**point, unknown: fmpq(x)}) for x in (0, 1, 2)]
    demand((at[2] - 2 * at[1] + at[0]).contains(0), "the derivation is not linear in the unknown")
    left = value_at(sides[0], {**point, unknown: at[0] / (at[0] - at[1])})
    modulus = 2 * arb.pi() if entry["direction"] else None
    demand(not left.contains(0) and not is_small(left, 1, modulus, CLOSE), "the print holds there")


def check_values(entry):
    """A definition gives the values that the paper prints beside it, to their last digits."""
    for shown in entry["values"]:
        point = {}
        for name, text in shown["values"].items():
            half = fmpq(1, 2) / fmpq(10) ** len(text.partition(".")[2])
            point[name] = arb(number(text), arb(half))
        for name, ends in shown["between"].items():
            low, high = (value_at(parse(text), point) for text in ends)
            point[name] = low.union(high)
        gap = value_at(find_transcription(entry), point)
        demand(gap.contains(0), f"it does not give {shown['where']}")


def check_entry(entry, others):
    """Return how a verdict under one reading was checked."""
    verdict, lacks, left = (entry[key] for key in ("verdict", "missing", "unexplained"))
    if verdict == "reconstructed" or not entry["derived"]:
        demand(verdict in ("reconstructed", "definition", "untested"), f"{verdict} of nothing")
        demand(verdict != "reconstructed" or entry["legibility"] == "lost", NOT_LOST)
        check_values(entry)
        return "by their values alone"
    check_reading(entry)
    if verdict in ("confirmed", "confirmed as rebuilt", "untested"):
        demand(not (lacks or left or entry["steps"] or entry["flips"]), NO_TERM)
        if entry["points"]:
            check_witness(entry)
        return check_identity(entry, parse(entry["start"]))
    terms = {"misprint": (False, False), "incomplete": (True, False)}
    is_condition = entry["relations"][0] != "="
    demand(verdict in (*terms, "contradicted"), f"{verdict} is no verdict")
    check_witness(entry)
    if entry["loose"] or (is_condition and verdict == "contradicted"):
        return "at their witness points"
    demand(terms.get(verdict, (bool(lacks), True)) == (bool(lacks), bool(left)), NO_TERM)
    corrections = entry["steps"] or [[]]
    demand(verdict != "misprint" or any(corrections) or entry["flips"], "nothing was corrected")
    ways = [check_identity(entry, correct(entry, steps)) for steps in corrections]
    if others:
        check_missing(entry, others, correct(entry, corrections[0]))
    return max(ways, key=len)


def check_record(record, tables):
    """Return how the verdict on an equation was checked, under every reading."""
    shared = {key: record[key] for key in COMMON} | {"table": tables[record["paper"]]}
    entries = [shared | reading for reading in record["readings"]]
    taken = entries[record["taken"]]
    demand(record["verdict"] == taken["verdict"], "the verdict is that of another reading")
    known = [check_entry(entry, entries if entry is taken else ()) for entry in entries]
    demand(record["statement"] == describe(record), "the statement is not what was checked")
    return known[record["taken"]]


def describe(record):
    """Return a verdict in words, made of what is checked of it."""
    if not record["readings"]:
        return "it was not judged"
    taken, verdict = record["readings"][record["taken"]], record["verdict"]
    words = [step["words"] for step in (taken["steps"] or [[]])[0]]
    words[:0] = ["{1} for {0}".format(*taken["relations"])] if taken["flips"] else []
    corrected = f"corrected ({'; '.join(words)}) " if words else ""
    sentences = {
        "misprint": f"{corrected}it is the derivation",
        "incomplete": f"{corrected}it lacks {', '.join(taken['missing'])}",
        "contradicted": "it fails where the derivation holds",
        "definition": f"it gives {', '.join(shown['where'] for shown in record['values'])}",
        "reconstructed": "the print is lost; the derivation stands alone",
        "untested": "it says what its symbols mean; nothing here tests it",
    }
    sentence = sentences.get(verdict, "print and derivation are the same")
    return sentence + (" where the machine uses it, and not everywhere" if taken["points"] else "")


def main(arguments):
    """Check a file of verdicts, and return the exit code."""
    counts, record = Counter(), {}
    try:
        document = json.loads(Path(*arguments).read_text(encoding="utf-8"))
        records, tables = document["records"], document["definitions"]
    except (OSError, ValueError, LookupError, TypeError) as error:
        return print(f"no file of verdicts: {error!r}") or 2
    try:
        for record in records:
            counts[check_record(record, tables)] += 1
    except FAILURES as error:
        return print(f"{record.get('paper')} ({record.get('equation')}): {error!r}") or 1
    print(*(f"{count} verdicts checked {known}" for known, count in counts.items()), sep="\n")
    return print("valid") or 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
