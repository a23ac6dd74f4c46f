"""What the file of a proof claims: whether its parts fit together, and the claim in words.

Nothing of it is evidence. `check_proof.py` beside this module has the same rules, and shares no
code with it.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from typing import Any

from planter.optimise.proof.programs import RecordedProgram, RecordedStep

Document = Mapping[str, Any]
FORMAT = "planter proof 2"
KEYS = frozenset(
    (
        "format",
        "planter",
        "statement",
        "generated",
        "parameters",
        "quantities",
        "kind",
        "samples",
        "response",
        "terms",
        "limits",
        "all_limits",
        "box",
        "incumbent",
        "lower_bound",
        "nodes",
        "sha256",
    )
)
WORDS = frozenset(
    ("format", "planter", "statement", "generated", "parameters", "quantities", "sha256")
)
"""Keys whose values are text, not numbers."""
KINDS: Mapping[str, type] = {
    "planter": str,
    "generated": dict,
    "parameters": list,
    "quantities": list,
    "response": dict,
    "terms": list,
    "limits": list,
    "all_limits": bool,
    "box": list,
    "incumbent": dict,
    "nodes": list,
}
"""Kinds of the values of some keys."""
UNBOUNDED = frozenset(("bound", "lower_bound"))
"""Keys whose numbers may be infinite: no design of a box satisfies the limits."""
WEIGHTS = {"max": (0.0, math.inf), "range": (0.0, math.inf), "min": (-math.inf, 0.0)}
"""Weights of measures that are bounded as greatest values of a quantity, or of minus it, times the
size of a weight.
"""
MEASURES = (*WEIGHTS, "mean", "variance", "std", "rms", "at")


class RefusedError(Exception):
    """A statement of a file does not follow."""


def refuse_unless(holds: bool, reason: str) -> None:
    """Raise RefusedError with a reason unless a statement holds."""
    if not holds:
        raise RefusedError(reason)


def check_claims(document: Document) -> None:
    """Raise RefusedError unless the parts of a document fit together and its statement is what they
    say.

    Raises ValueError, KeyError, TypeError or IndexError for a document without these parts.
    """
    refuse_unless(
        document.keys() == KEYS,
        f"it has the keys {_differing(document)}, which no such file has or lacks",
    )
    refuse_unless(document["format"] == FORMAT, f"format must be {FORMAT!r}")
    for key, kind in KINDS.items():
        refuse_unless(isinstance(document[key], kind), f"{key} must be of the kind {kind.__name__}")
    for place in _list_not_finite(document):
        raise RefusedError(f"{place} is not finite")
    _check_generated(document["generated"])
    _check_box(document)
    samples = document["samples"]
    is_count = isinstance(samples, int) and not isinstance(samples, bool) and samples > 0
    refuse_unless(
        samples is None or is_count, f"samples = {samples!r} must be a positive integer or null"
    )
    refuse_unless(
        document["kind"] == ("true" if samples is None else "sampled"), "kind does not fit samples"
    )
    _check_measures(document)
    statement = compose_statement(document)
    refuse_unless(
        document["statement"] == statement,
        f"statement does not follow from the file, which says: {statement}",
    )


def _differing(document: Document) -> str:
    return ", ".join(sorted(map(repr, KEYS.symmetric_difference(document))))


def _list_not_finite(value: Any, key: str = "", place: str = "the file") -> Iterator[str]:
    """Yield the places of numbers that are none, or are infinite where they may not be."""
    if isinstance(value, Mapping):
        for name, part in value.items():
            if place != "the file" or name not in WORDS:
                yield from _list_not_finite(
                    part, name, name if place == "the file" else f"{place}.{name}"
                )
    elif isinstance(value, list):
        for index, part in enumerate(value):
            yield from _list_not_finite(part, key, f"{place}[{index}]")
    elif isinstance(value, str | float) and not _is_finite(value, key, place):
        yield place


def _is_finite(value: str | float, key: str, place: str) -> bool:
    try:
        number = float.fromhex(value) if isinstance(value, str) else value
    except ValueError:  # a name, or no number; whoever reads it says so
        return True
    except OverflowError:
        return False
    is_limit = key == "limits" and place.startswith("response")  # how far roots are looked for
    return math.isfinite(number) or (number == math.inf and (key in UNBOUNDED or is_limit))


def _check_generated(hashes: Mapping[str, Any]) -> None:
    """Refuse a file that does not say from which generated modules its programs were recorded."""
    refuse_unless(
        bool(hashes),
        "generated must hold the hashes of the modules that the programs were recorded from",
    )
    for name, digest in hashes.items():
        is_hash = isinstance(digest, str) and re.fullmatch("[0-9a-f]{64}", digest) is not None
        refuse_unless(is_hash, f"generated.{name} must be a SHA-256")


def _check_box(document: Document) -> None:
    names, (lower, upper) = document["parameters"], document["box"]
    count = document["response"]["parameters"]
    are_names = all(isinstance(name, str) and name for name in names) and len(set(names)) == len(
        names
    )
    refuse_unless(are_names, "parameters must be different names")
    fits = len(names) == len(lower) == len(upper) == count
    refuse_unless(fits, "parameters, box and response differ in their number of parameters")
    for name, low, high in zip(names, _read(lower), _read(upper), strict=True):
        refuse_unless(low <= high, f"box: {name} from {low} to {high} is empty")
    incumbent = document["incumbent"]
    refuse_unless(
        len(incumbent["x"]) == count, "incumbent.x differs from the box in its number of parameters"
    )
    response = document["response"]
    refuse_unless(Fraction(response["period"]) > 0, "response.period must be positive")
    refuse_unless(
        isinstance(response["continuous"], bool), "response.continuous must be true or false"
    )
    for place, node in enumerate(document["nodes"]):
        _check_evidence(node.get("evidence"), count, f"nodes[{place}].evidence")
    _check_evidence(incumbent.get("evidence"), count, "incumbent.evidence")


def _check_evidence(evidence: Mapping[str, Any] | None, count: int, place: str) -> None:
    """Refuse evidence whose numbers are not those of as many parameters."""
    parts = evidence or {}
    rates = [part["rates"] for key in ("panels", "narrow") if (part := parts.get(key)) is not None]
    for row in (row for some in (*rates, parts.get("rates", [])) for row in some):
        refuse_unless(
            len(row) == count, f"{place}: rates must have a number for each of {count} parameters"
        )


def _check_measures(document: Document) -> None:
    """Refuse measures that the rules of bounds do not cover."""
    program = RecordedProgram.from_document(document["response"]["stages"][-1])
    labels, outputs = document["quantities"], program.outputs
    are_labels = all(isinstance(label, str) and label for label in labels) and len(
        set(labels)
    ) == len(labels)
    refuse_unless(
        are_labels and len(labels) == len(outputs),
        "quantities must be different names, one for each result",
    )
    sizes = list_nonnegative(program.operations)
    refuse_unless(bool(document["terms"]), "terms: there must be at least one")
    for key in ("terms", "limits"):
        for index, entry in enumerate(document[key]):
            place, kind, quantity = f"{key}[{index}]", entry["measure"], entry["quantity"]
            refuse_unless(kind in MEASURES, f"{place}.measure = {kind!r} is not known")
            is_index = isinstance(quantity, int) and not isinstance(quantity, bool)
            refuse_unless(
                is_index and 0 <= quantity < len(outputs),
                f"{place}.quantity = {quantity!r} is no result",
            )
            refuse_unless(
                (kind == "at") == (entry["angle_deg"] is not None),
                f"{place}.angle_deg does not fit {kind}",
            )
            refuse_unless(isinstance(entry["size"], bool), f"{place}.size must be true or false")
            is_size = sizes[outputs[quantity]]
            refuse_unless(
                is_size or not entry["size"],
                f"{place}.size: the program may give a negative number",
            )
            weight = float.fromhex(entry["weight"])
            low, high = (1.0, 1.0) if key == "limits" else WEIGHTS.get(kind, (-math.inf, math.inf))
            refuse_unless(
                low <= weight <= high,
                f"{place}.weight = {weight} is not covered by the rule of {kind}",
            )
            is_sign = entry.get("sign") in (1, -1) and not isinstance(entry.get("sign"), bool)
            refuse_unless(key == "terms" or is_sign, f"{place}.sign must be 1 or -1")


def list_nonnegative(operations: Sequence[RecordedStep]) -> list[bool]:
    """Return for each step of a program whether its result is certainly nowhere below zero, by its
    form alone.
    """
    sizes: list[bool] = []
    for step in operations:
        parts = [sizes[k] for k in step.arguments]
        match step.name:
            case "constant":
                is_size = step.numbers[0] >= 0
            case "pi" | "sqrt" | "exp":
                is_size = True
            case "add" | "inverse":
                is_size = all(parts)
            case "multiply":
                is_size = all(parts) or step.arguments[0] == step.arguments[1]
            case "power":
                is_size = step.numbers[0] % 2 == 0 or parts[0]
            case "select":
                is_size = all(parts[:2]) or _is_absolute(operations, step)
            case _:
                is_size = False
        sizes.append(is_size)
    return sizes


def _is_absolute(operations: Sequence[RecordedStep], step: RecordedStep) -> bool:
    """Return whether a selection takes x where -x is not above zero, and -x elsewhere."""
    value, other, condition = step.arguments
    if operations[condition].name != "below" or not _is_negated(operations, other, value):
        return False
    (difference,) = operations[condition].arguments
    if operations[difference].name == "add":  # of 0 - x
        first, second = operations[difference].arguments
        zeros = [
            k
            for k in (first, second)
            if operations[k].name == "constant" and operations[k].numbers[0] == 0
        ]
        difference = next((k for k in (first, second) if zeros and k != zeros[0]), difference)
    return _is_negated(operations, difference, value)


def _is_negated(operations: Sequence[RecordedStep], index: int, value: int) -> bool:
    return operations[index].name == "negate" and operations[index].arguments == (value,)


def _read(values: Sequence[str]) -> list[float]:
    return [float.fromhex(value) for value in values]


def compose_statement(document: Document) -> str:
    """Return in words what a document claims, from the parts that define it: numbers with all their
    digits.
    """
    names, (lower, upper) = document["parameters"], map(_read, document["box"])
    response, samples = document["response"], document["samples"]
    box = ", ".join(
        f"{name} = {low!r}" if low == high else f"{name} from {low!r} to {high!r}"
        for name, low, high in zip(names, lower, upper, strict=True)
    )
    over = "over the whole cycle" if samples is None else f"over {samples} samples of the cycle"
    cycle = f"the period {response['period']} turns, sides at {' and '.join(response['offsets'])}"
    roots = (
        ", roots near those of the evidence"
        if any(stage["limits"] for stage in response["stages"])
        else ""
    )
    smooth = "results that do not jump" if response["continuous"] else "results that may jump"
    total = " + ".join(
        f"{float.fromhex(term['weight'])!r} {_describe_measure(term, document)}"
        for term in document["terms"]
    )
    limits = " and ".join(
        f"{_describe_measure(limit, document)} {'<=' if limit['sign'] > 0 else '>='} "
        f"{float.fromhex(limit['limit'])!r}"
        for limit in document["limits"]
    )
    heeded = "" if document["all_limits"] else " (other limits are not heeded)"
    bound, reached = document["lower_bound"], document["incumbent"]["upper_bound"]
    x = ", ".join(
        f"{name} = {value!r}"
        for name, value in zip(names, _read(document["incumbent"]["x"]), strict=True)
    )
    claim = (
        "nothing bounds it from below"
        if bound is None
        else f"no design is below {float.fromhex(bound)!r}"
    )
    reached_claim = (
        "no design was enclosed"
        if reached is None
        else f"the design {x} is at most {float.fromhex(reached)!r}"
    )
    return (
        f"Of {total}, {over}, with {cycle}{roots} and {smooth}, for {box} in SI units"
        f"{', where ' + limits if limits else ''}{heeded}: {claim}; {reached_claim}."
    )


def _describe_measure(entry: Mapping[str, Any], document: Document) -> str:
    angle = entry["angle_deg"]
    where = "" if angle is None else f" at {float.fromhex(angle)!r} deg"
    kind = "value" if angle is not None else entry["measure"]
    return f"{kind} of {document['quantities'][entry['quantity']]}{where}"
