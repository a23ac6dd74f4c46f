"""Check verdicts on printed equations without planter and without derive: python check_verdicts.py
FILE.

Trusted are the transcriptions, the meanings that readings give to symbols, the derivations and the
definitions of derived quantities. Everything else is repeated: that readings lead from a
transcription to what was judged, that each correction is carried out and needed, that print,
corrections and missing terms are the derivation, that a term which is called missing does not
stand in the print under any reading, and that a print which is called wrong fails at its witness
point. Equality is exact: of rational functions of the quantities and of sines and cosines with
c2 + s2 = 1. Where other functions remain, it is tried with error bounds at 40 random rational
points. Needs the standard library and python-flint. Exit code 1 if a verdict does not follow, 2
for a file that is none; the last line is `valid` or names the first such verdict.
"""

from __future__ import annotations

import ast
import json
import operator
import random
import sys
from functools import cache, reduce
from pathlib import Path

from flint import arb, ctx, fmpq, fmpq_mpoly_ctx

SAMPLES, TRIES = 40, 4000
ctx.prec = 400
SMALL = arb(10) ** -60
"""What is left of terms of size one where two sides are equal, far above rounding at 400 bits."""
RELATIONS = {"<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge}
FLIPPED = {"=": "=", "<": ">", ">": "<", "<=": ">=", ">=": "<="}
SOUND, FAULTS = ("confirmed", "confirmed as rebuilt"), ("misprint", "incomplete", "contradicted")
AST_RELATIONS = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">="}


class Refused(Exception):
    """A verdict does not follow from what the file states."""


class Undecided(Exception):
    """An expression has no real value at a point, or a condition cannot be decided there."""


# Expressions: ("num", q), ("sym", name), ("add" | "mul" | "and" | "or", ...), ("pow", b, e),
# ("call", name, ...), ("case", (expr, condition), ...), ("rel", sign, a, b), ("true",)


@cache
def parse(text):
    return convert(ast.parse(text, mode="eval").body)


def convert(node):
    if isinstance(node, ast.Constant):
        if node.value is True:
            return ("true",)
        return ("num", number(str(node.value)))
    if isinstance(node, ast.Name):
        return ("true",) if node.id == "True" else ("sym", node.id)
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        return product(("num", fmpq(-1)), convert(node.operand))
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Invert):
        return ("not", convert(node.operand))
    if isinstance(node, ast.BinOp):
        left, right = convert(node.left), convert(node.right)
        if isinstance(node.op, ast.Add):
            return nested("add", left, right)
        if isinstance(node.op, ast.Sub):
            return nested("add", left, product(("num", fmpq(-1)), right))
        if isinstance(node.op, ast.Mult):
            return product(left, right)
        if isinstance(node.op, ast.Div):
            return product(left, power(right, fmpq(-1)))
        if isinstance(node.op, ast.Pow):
            return power(left, right[1]) if right[0] == "num" else ("pow", left, right)
        if isinstance(node.op, ast.BitAnd | ast.BitOr):
            return ("and" if isinstance(node.op, ast.BitAnd) else "or", left, right)
    if isinstance(node, ast.Compare) and len(node.ops) == 1:
        sign = AST_RELATIONS[type(node.ops[0])]
        return ("rel", sign, convert(node.left), convert(node.comparators[0]))
    if isinstance(node, ast.Call) and node.func.id == "Piecewise":
        return ("case", *(tuple(map(convert, pair.elts)) for pair in node.args))
    if isinstance(node, ast.Call):
        arguments = tuple(map(convert, node.args))
        if node.func.id == "sqrt":
            return power(arguments[0], fmpq(1, 2))
        return ("call", node.func.id, *arguments)
    raise ValueError(f"not a formula: {ast.unparse(node)}")


def number(text):
    if "/" in text:
        return fmpq(*map(int, text.split("/")))
    digits, _, exponent = text.lower().partition("e")
    whole, _, fraction = digits.partition(".")
    return fmpq(int(whole + fraction)) * fmpq(10) ** (int(exponent or 0) - len(fraction))


def nested(kind, *parts):
    """Return a sum or product whose parts are none themselves, in an order of their own."""
    flat = [x for part in parts for x in (part[1:] if part[0] == kind else (part,))]
    return flat[0] if len(flat) == 1 else (kind, *sorted(flat, key=repr))


def product(*parts):
    """Return a product with one number in front."""
    flat = nested("mul", *parts)
    if flat[0] != "mul":
        return flat
    value = reduce(operator.mul, (p[1] for p in flat[1:] if p[0] == "num"), fmpq(1))
    rest = [p for p in flat[1:] if p[0] != "num"]
    return nested("mul", *([("num", value)] if value != 1 or not rest else []), *rest)


def power(base, exponent):
    if base[0] == "num" and exponent.q == 1 and (exponent >= 0 or base[1] != 0):
        return ("num", base[1] ** int(exponent))
    if base[0] == "pow" and base[2][0] == "num" and exponent.q == 1:
        return power(base[1], base[2][1] * exponent)
    if base[0] == "mul" and exponent == -1:
        return product(*(power(part, exponent) for part in base[1:]))
    return base if exponent == 1 else ("pow", base, ("num", exponent))


def rebuild(tree, change):
    """Return a tree with its parts changed by a function."""
    if tree[0] in ("num", "sym", "true"):
        return tree
    if tree[0] == "case":
        return ("case", *((change(value), change(condition)) for value, condition in tree[1:]))
    kept = 2 if tree[0] in ("call", "rel") else 1
    parts = tuple(map(change, tree[kept:]))
    if tree[0] == "pow" and parts[1][0] == "num":
        return power(parts[0], parts[1][1])
    joined = {"add": lambda: nested("add", *parts), "mul": lambda: product(*parts)}
    return joined.get(tree[0], lambda: (*tree[:kept], *parts))()


def substitute(tree, meanings):
    if tree[0] == "sym":
        return meanings.get(tree[1], tree)
    return rebuild(tree, lambda part: substitute(part, meanings)) if meanings else tree


def parts_of(tree):
    """Return the expressions and conditions of which an expression consists."""
    if tree[0] in ("num", "sym", "true"):
        return ()
    if tree[0] == "case":
        return tuple(part for pair in tree[1:] for part in pair)
    return tree[2 if tree[0] in ("call", "rel") else 1 :]


def symbols(tree):
    if tree[0] == "sym":
        return {tree[1]} - {"pi"}
    return set().union(*map(symbols, parts_of(tree)))


class Ring:
    """Rational functions of symbols, of cosine and sine of each angle, and of other functions as
    they stand."""

    def __init__(self, trees):
        size = 1 + sum(map(count_generators, trees))
        self.polynomials = fmpq_mpoly_ctx.get(("x", size), "degrevlex")
        self.generators, self.names, self.circles = iter(self.polynomials.gens()), {}, []
        self.one = self.polynomials.constant(1)

    def generator(self, key):
        if key not in self.names:
            self.names[key] = next(self.generators)
        return self.names[key]

    def circle(self, key):
        pair = self.generator(("cos", key)), self.generator(("sin", key))
        if pair not in self.circles:
            self.circles.append(pair)
        return pair

    def fraction(self, tree):
        """Return numerator and denominator of an expression."""
        kind = tree[0]
        if kind == "num":
            return self.one * tree[1], self.one
        if kind == "add":
            return reduce(self.add, map(self.fraction, tree[1:]))
        if kind == "mul":
            return reduce(self.times, map(self.fraction, tree[1:]))
        if kind == "pow" and tree[2][0] == "num" and tree[2][1].q == 1:
            above, below = self.fraction(tree[1])
            exponent = int(tree[2][1])
            return (
                (above**exponent, below**exponent)
                if exponent >= 0
                else (below**-exponent, above**-exponent)
            )
        if kind == "call" and tree[1] in ("sin", "cos"):
            return self.turn(tree[2])[tree[1] == "sin"], self.one
        if kind == "call" and tree[1] == "tan":
            return self.turn(tree[2])[::-1]
        return self.generator(tree), self.one

    def add(self, first, second):
        (a, b), (c, d) = first, second
        return (a + c, b) if b == d else self.lowest(a * d + c * b, b * d)

    def times(self, first, second):
        (a, b), (c, d) = first, second
        return self.lowest(a * c, b * d)

    def lowest(self, above, below):
        """Return a fraction without common factors, with squares of sines as those of cosines."""
        above, below = self.without_squares(above), self.without_squares(below)
        if not below.is_constant():
            common = above.gcd(below)
            above, below = above / common, below / common
        scale = below.leading_coefficient()
        return above / scale, below / scale

    def without_squares(self, polynomial):
        for cosine, sine in self.circles:
            place = self.polynomials.gens().index(sine)
            if polynomial.degrees()[place] < 2:
                continue
            parts = {}
            for powers, coefficient in polynomial.to_dict().items():
                rest = (*powers[:place], powers[place] % 2, *powers[place + 1 :])
                parts.setdefault(powers[place] // 2, {})[rest] = coefficient
            polynomial = sum(
                (
                    self.polynomials.from_dict(part) * (1 - cosine**2) ** n
                    for n, part in parts.items()
                ),
                0 * self.one,
            )
        return polynomial

    def turn(self, angle):
        """Return cosine and sine of an angle, by those of its terms."""
        above, below = self.lowest(*self.fraction(angle))
        if not below.is_constant():
            return self.circle((str(above), str(below)))
        cosine, sine = self.one, 0 * self.one
        for powers, value in above.to_dict().items():
            c, s = self.multiple(self.polynomials.from_dict({powers: fmpq(1)}), value)
            cosine, sine = cosine * c - sine * s, sine * c + cosine * s
        return cosine, sine

    def multiple(self, monomial, value):
        c, s = self.one, 0 * self.one
        quarters = 0
        if monomial == self.generator(("sym", "pi")):
            quarters = int((2 * value).floor())
            value -= fmpq(quarters, 2)
        if value:
            base = self.circle((str(monomial), str(fmpq(1, value.q))))
            for _ in range(abs(int(value.p))):
                c, s = c * base[0] - s * base[1], s * base[0] + c * base[1]
            s = s if value > 0 else -s
        for _ in range(quarters % 4):
            c, s = -s, c
        return c, s


def count_generators(tree):
    """Return at least how many generators an expression may need."""
    if tree[0] in ("num", "sym", "true"):
        return 1
    inner = sum(map(count_generators, parts_of(tree)))
    return 2 * inner + 2 if tree[0] in ("call", "case", "pow") else max(inner, 1)


def value_at(tree, point):
    """Return the value of an expression at a point, with error bounds."""
    kind = tree[0]
    if kind == "num":
        return arb(tree[1])
    if kind == "sym":
        return arb.pi() if tree[1] == "pi" else arb(point[tree[1]])
    if kind == "case":
        return next(
            (value_at(v, point) for v, condition in tree[1:] if is_true(condition, point)), arb(0)
        )
    values = [value_at(part, point) for part in tree[(2 if kind == "call" else 1) :]]
    if kind in ("add", "mul"):
        result = reduce(operator.add if kind == "add" else operator.mul, values)
    elif kind == "pow":
        result = values[0] ** (
            int(tree[2][1]) if tree[2][0] == "num" and tree[2][1].q == 1 else values[1]
        )
    elif tree[1] == "Abs":
        result = abs(values[0])
    elif tree[1] == "atan2":
        result = arb.atan2(values[0], values[1])
    elif tree[1] in ("Min", "Max"):
        result = reduce(getattr(arb, tree[1].lower()), values)
    else:
        result = getattr(values[0], {"sign": "sgn"}.get(tree[1], tree[1]))()
    if not result.is_finite():
        raise Undecided
    return result


def is_true(tree, point):
    if tree[0] == "true":
        return True
    if tree[0] == "not":
        return not is_true(tree[1], point)
    if tree[0] in ("and", "or"):
        return (all if tree[0] == "and" else any)(is_true(part, point) for part in tree[1:])
    return holds(tree[1], value_at(tree[2], point) - value_at(tree[3], point))


def holds(sign, difference):
    if difference.contains(0):
        raise Undecided
    return bool(RELATIONS[sign](difference, 0))


def is_rational(tree):
    """Return whether nothing but sines, cosines and tangents stands beside rational functions."""
    if tree[0] in ("case", "rel") or (tree[0] == "call" and tree[1] not in ("sin", "cos", "tan")):
        return False
    if tree[0] == "pow" and (tree[2][0] != "num" or tree[2][1].q != 1):
        return False
    return all(map(is_rational, parts_of(tree)))


def is_zero_exactly(tree):
    if not is_rational(tree):
        return False
    ring = Ring([tree])
    return ring.without_squares(ring.fraction(tree)[0]) == 0


def draw_points(entry, names):
    """Yield random rational points of an entry's ranges."""
    source = random.Random(f"{entry['paper']} {entry['equation']}")
    for _ in range(TRIES):
        point = {}
        for name in sorted(names):
            low, high = map(number, entry["ranges"].get(name, ("1/5", "2")))
            point[name] = low + (high - low) * fmpq(source.randint(1, 10**6), 10**6 + 1)
        yield point


def vanishes(tree, entry, modulus=None):
    """Return how a difference is known to vanish, "" if it does not."""
    if modulus is None and is_zero_exactly(tree):
        return "exactly"
    where, count = parse(entry.get("where") or "True"), 0
    for point in draw_points(entry, symbols(tree) | symbols(where)):
        try:
            if not is_true(where, point):
                continue
            if not is_small(value_at(tree, point), tree, point, modulus):
                return ""
        except (Undecided, ZeroDivisionError):
            continue
        count += 1
        if count == SAMPLES:
            return f"at {SAMPLES} random points"
    raise Refused(f"no {SAMPLES} points at which both sides have values")


def is_small(value, tree, point, modulus):
    if modulus is not None:
        value -= modulus * (value / modulus + fmpq(1, 2)).mid().floor()
    largest = max(
        [arb(1), *(abs(value_at(part, point)) for part in (tree[1:] if tree[0] == "add" else ()))],
        key=lambda size: float(size.mid()),
    )
    return (value.contains(0) and bool(value.rad() < SMALL * largest)) or bool(
        abs(value) < SMALL * largest
    )


def minus(first, second):
    return nested("add", first, product(("num", fmpq(-1)), second))


def define(tree, entry, names):
    """Return an expression with defined quantities replaced, in the order of the names."""
    for name in names:
        tree = substitute(tree, {name: parse(entry["table"][name])})
    return tree


def residual(side, entry):
    return minus(("sym", entry["defines"]), side) if entry["solved"] else side


def are_same(first, second, entry):
    """Return how two residuals are known to be equal, after the definitions that an entry names."""
    difference = define(minus(first, second), entry, entry["definitions"])
    modulus = 2 * arb.pi() if entry["direction"] else None
    return vanishes(difference, entry) or (modulus and vanishes(difference, entry, modulus)) or ""


def demand(condition, what):
    if not condition:
        raise Refused(what)


def check_reading(entry):
    text = parse(entry["text"] or entry["transcription"])
    meanings = {name: parse(meant) for name, meant in entry["meanings"].items()}
    read = define(substitute(text, meanings), entry, entry["through"])
    plain = {**entry, "direction": False}
    demand(
        are_same(read, parse(entry["read"]), plain), "the readings do not lead to what was judged"
    )
    start = residual(parse(entry["start"]), entry)
    scaled = product(parse(entry["undivided"]), parse(entry["read"]))
    demand(are_same(start, scaled, plain), "what was corrected is not what was read")


def replacements(tree, old, new):
    """Yield a tree with one part replaced by another, at each place where it stands."""
    if tree == old:
        yield new
    kind = tree[0]
    if kind in ("add", "mul") and old[0] == kind and len(old) < len(tree):
        left = list(tree[1:])
        if all(part in left and left.remove(part) is None for part in old[1:]):
            yield (nested("add", *left, new) if kind == "add" else product(*left, new))
    for place, part in enumerate(parts_of(tree)):
        for changed in replacements(part, old, new):
            parts = iter([*parts_of(tree)[:place], changed, *parts_of(tree)[place + 1 :]])
            yield rebuild(tree, lambda _, parts=parts: next(parts))


def check_steps(entry, steps):
    """Return the side after corrections of which each is one replacement."""
    side = parse(entry["start"])
    for step in steps:
        after = parse(step["after"])
        if step["swaps"]:
            changed = [substitute(side, {old: parse(new) for old, new in step["swaps"].items()})]
        else:
            changed = replacements(side, parse(step["old"]), parse(step["new"]))
        exact = {**entry, "direction": False, "definitions": []}
        demand(
            any(some == after or are_same(some, after, exact) for some in changed),
            f"{step['words']!r} is not what was done",
        )
        side = after
    return side


def check_identity(entry, side):
    """Print, corrections and missing terms less unexplained ones are the derivation."""
    parts = [*map(parse, entry["missing"])]
    parts += [product(("num", fmpq(-1)), parse(text)) for text in entry["unexplained"]]
    completed = residual(nested("add", side, *parts), entry)
    multiple, derived = parse(entry["multiple"]), parse(entry["derived"])
    printed_sign, sign, derived_sign = entry["relations"]
    factor = product(multiple, parse(entry["undivided"]))
    demand(factor != ("num", fmpq(0)), "a multiple of zero says nothing")
    demand(entry["flips"] == (sign != printed_sign), "the relation is another than was said")
    if derived_sign != "=":
        demand(factor[0] == "num", "conditions differ by more than a number")
        demand(
            (sign if factor[1] > 0 else FLIPPED[sign]) == derived_sign, "the relation is another"
        )
    known = are_same(completed, product(multiple, derived), entry)
    demand(known, "print, corrections and terms are not the derivation")
    return known


def coefficients(tree, ring):
    above, below = ring.fraction(tree)
    return {
        powers: value / below.leading_coefficient() for powers, value in above.to_dict().items()
    }


def check_missing(entry, others, side):
    """What is called missing stands in the print under no reading."""
    names = [*entry["definitions"], *entry["meaning_of_missing"]]
    prints = [parse(entry["start"])]
    prints += [parse(other["start"]) for other in others if other["solved"] == entry["solved"]]
    missing = nested("add", ("num", fmpq(0)), *map(parse, entry["missing"]))
    unexplained = nested("add", ("num", fmpq(0)), *map(parse, entry["unexplained"]))
    trees = [define(tree, entry, names) for tree in (*prints, missing, unexplained, side)]
    ring = Ring(trees)
    *printed, lacking, loose, corrected = (coefficients(tree, ring) for tree in trees)
    for powers, value in lacking.items():
        total = corrected.get(powers, 0) + value - loose.get(powers, 0)
        for some in printed:
            here = some.get(powers, 0)
            more = here * total > 0 and abs(total) > abs(here) and value * total > 0
            demand(here == 0 or more, "a term that is called missing stands in the print")


def check_witness(entry):
    """Return what is left of the print at a point where the derivation holds."""
    point = {name: number(value) for name, value in entry["witness"]["values"].items()}
    printed, derived = parse(entry["read"]), parse(entry["derived"])
    if entry["relations"][0] != "=":
        truths = [
            holds(sign, value_at(tree, point))
            for sign, tree in zip(entry["relations"][::2], (printed, derived), strict=True)
        ]
        demand(truths[0] != truths[1], "print and derivation agree at the witness point")
        return None
    unknown = entry["witness"]["unknown"]
    at = [value_at(derived, {**point, unknown: arb(x)}) for x in (0, 1, 2)]
    demand((at[2] - 2 * at[1] + at[0]).contains(0), "the derivation is not linear in the unknown")
    left = value_at(printed, {**point, unknown: -at[0] / (at[1] - at[0])})
    whole = left / (2 * arb.pi())
    turned = entry["direction"] and (whole - (whole + fmpq(1, 2)).mid().floor()).contains(0)
    demand(not left.contains(0) and not turned, "the print holds at the witness point")
    return left


def check_values(entry):
    """A definition gives the values that the paper prints beside it, to their last digits."""
    tree = parse(entry["transcription"])
    for shown in entry["values"]:
        point = {name: spread(text) for name, text in shown["values"].items()}
        for name, bounds in shown["between"].items():
            low, high = (value_at(parse(text), point) for text in bounds)
            point[name] = low.union(high)
        demand(value_at(tree, point).contains(0), f"it does not give {shown['where']}")


def spread(text):
    digits = len(text.partition(".")[2])
    return arb(number(text), arb(fmpq(1, 2) / fmpq(10) ** digits))


def check_entry(entry, others):
    """Return how a verdict under one reading was checked."""
    verdict = entry["verdict"]
    if verdict in ("reconstructed", "not judged"):
        demand(verdict == "not judged" or entry["legibility"] == "lost", "the print is not lost")
        return ""
    if verdict == "definition" or (verdict == "untested" and not entry["derived"]):
        check_values(entry)
        return ""
    check_reading(entry)
    if verdict in (*SOUND, "untested"):
        rest = ("steps", "missing", "unexplained", "flips")
        demand(not any(entry[part] for part in rest), "nothing is to be corrected in a sound print")
        if entry["points"]:
            check_witness(entry)
            return check_points(entry)
        return check_identity(entry, parse(entry["start"]))
    demand(verdict in FAULTS, f"{verdict!r} is no verdict")
    if entry["loose"]:
        point = {name: number(value) for name, value in entry["witness"]["values"].items()}
        left = [value_at(parse(text), point) for text in entry["loose"].values()]
        demand(not any(value.contains(0) for value in left), "what must vanish does")
        return "at its witness point"
    check_witness(entry)
    demand(
        verdict != "misprint" or (entry["steps"] or entry["flips"]), "a misprint has a correction"
    )
    demand(verdict == "misprint" or entry["missing"] or entry["unexplained"], "no term is left")
    demand(
        (verdict == "contradicted") == bool(entry["unexplained"]), "an unexplained term contradicts"
    )
    demand(verdict != "misprint" or not entry["missing"], "a misprint lacks no term")
    if entry["relations"][0] != "=" and verdict == "contradicted":
        return "at its witness point"
    ways = [check_identity(entry, check_steps(entry, steps)) for steps in entry["steps"] or [[]]]
    check_missing(entry, others, check_steps(entry, (entry["steps"] or [[]])[0]))
    return max(ways, key=len)


def check_points(entry):
    difference = minus(parse(entry["read"]), parse(entry["derived"]))
    for values in entry["points"]:
        point = {name: number(value) for name, value in values.items()}
        demand(is_small(value_at(difference, point), difference, point, None), "it fails in use")
    return f"at {len(entry['points'])} points of use"


COMMON = ("paper", "equation", "legibility", "transcription", "defines", "direction", "values")


def check_record(record, tables):
    """Return how the verdict on an equation was checked, under all readings."""
    shared = {key: record[key] for key in COMMON} | {"table": tables[record["paper"]]}
    entries = [shared | reading for reading in record["readings"]]
    taken = entries[record["taken"]]
    demand(record["verdict"] == taken["verdict"], "the verdict is not that of the reading taken")
    known = [check_entry(entry, entries if entry is taken else []) for entry in entries]
    demand(record["statement"] == describe(record), "the statement is not what was checked")
    return known[record["taken"]]


def describe(record):
    """Return the verdict in words, made of what is checked of it."""
    taken = record["readings"][record["taken"]]
    steps, missing = (taken["steps"] or [[]])[0], taken["missing"]
    words = [step["words"] for step in steps]
    signs = taken["relations"]
    words = [f"{signs[1]} for {signs[0]}", *words] if taken["flips"] else words
    corrections = "; ".join(words)
    count = f"{len(words)} correction{'s' if len(words) != 1 else ''}"
    lacking = f"{len(missing)} term{'s' if len(missing) != 1 else ''}"
    sentences = {
        "confirmed": "print and derivation are the same",
        "confirmed as rebuilt": "what was read and rebuilt is the derivation",
        "untested": "it says what its symbols mean, and nothing here can test that",
        "definition": f"it gives what the paper prints: {', '.join(v['where'] for v in record['values'])}",
        "reconstructed": "the print is lost; the derivation stands alone",
        "misprint": f"{count} make{'s' if len(words) == 1 else ''} it the derivation: {corrections}",
        "incomplete": f"it lacks {lacking} of the derivation"
        + (f", after {count}: {corrections}" if words else ""),
        "contradicted": "it does not hold where the derivation does",
    }
    sentence = sentences.get(record["verdict"], "it was not judged")
    return sentence + (" where the machine uses it, and not everywhere" if taken["points"] else "")


def main(arguments):
    try:
        document = json.loads(Path(arguments[0]).read_text(encoding="utf-8"))
        records, tables = document["records"], document["definitions"]
    except (OSError, ValueError, KeyError, IndexError, TypeError) as error:
        print(f"no file of verdicts: {error!r}")
        return 2
    counts = {}
    for record in records:
        name = f"{record.get('paper')} ({record.get('equation')})"
        try:
            known = check_record(record, tables)
        except (
            Refused,
            Undecided,
            KeyError,
            ValueError,
            TypeError,
            ZeroDivisionError,
            SyntaxError,
            StopIteration,
            AttributeError,
            IndexError,
        ) as error:
            print(f"{name}: {error if isinstance(error, Refused) else repr(error)}")
            return 1
        counts[known] = counts.get(known, 0) + 1
    print(
        "\n".join(
            f"{count} verdicts checked {known or 'by their values alone'}"
            for known, count in sorted(counts.items())
        )
    )
    print("valid")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
