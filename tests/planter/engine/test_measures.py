"""The language of measures and limits: what it means, that its text reads back to the same, what it
refuses.
"""

import contextlib
import dataclasses
import random

import pytest

from planter.engine.measures import (
    KINDS,
    Extremum,
    Limit,
    Measure,
    MeasureCondition,
    format_sum,
    parse_limit,
    parse_measure,
    parse_sum,
)
from planter.errors import InputError

TEXTS = {
    "max F": Measure("max", "F"),
    "0.5 rms M_in": Measure("rms", "M_in", weight=0.5),
    "2 * max abs F_Ax": Measure("max", "F_Ax", size=True, weight=2),
    "2 jump F_Ox": Measure("jump", "F_Ox", weight=2),
    "-min F": Measure("min", "F", weight=-1),
    "-0.5 std s": Measure("std", "s", weight=-0.5),
    "1e-3 mean s": Measure("mean", "s", weight=1e-3),
    "s at -300 deg": Measure("at", "s", angle=-300),
    "range": Measure("all", "range"),
    "abs tilt where y_tip is least": Measure("at", "tilt", size=True, where=Extremum("y_tip", -1)),
    "mean F while y <= 20 mm and abs v > 0.1 m/s": Measure(
        "mean",
        "F",
        during=(
            MeasureCondition("y", 1, 20, "mm"),
            MeasureCondition("v", -1, 0.1, "m/s", absolute=True, strict=True),
        ),
    ),
    "rms distance x_tip y_tip to ../a-b/path.csv": Measure(
        "rms", "distance x_tip y_tip to ../a-b/path.csv"
    ),
    'distance x y to "my path.csv" at 90': Measure("at", 'distance x y to "my path.csv"', angle=90),
    "F where distance x y to p.csv is least": Measure(
        "at", "F", where=Extremum("distance x y to p.csv", -1)
    ),
    "max F while distance x y to p.csv <= 2 mm and y > 3": Measure(
        "max",
        "F",
        during=(
            MeasureCondition("distance x y to p.csv", 1, 2, "mm"),
            MeasureCondition("y", -1, 3, strict=True),
        ),
    ),
    "distance": Measure("all", "distance"),
    "distance where distance is least": Measure("at", "distance", where=Extremum("distance", -1)),
    "work P_in while n >= -3 r/min": Measure(
        "work", "P_in", during=(MeasureCondition("n", -1, -3, "r/min"),)
    ),
}


@pytest.mark.parametrize(("text", "measure"), TEXTS.items(), ids=TEXTS.keys())
def test_measure_has_meaning_in_sum_and_limit(text: str, measure: Measure) -> None:
    if measure.kind != "all":
        assert parse_sum(f"{text} + max G") == (measure, Measure("max", "G"))
    if measure.weight == 1 and (measure.kind, "<=") not in (("min", "<="),):
        assert parse_limit(f"{text} <= 3e2 kN") == Limit(measure, 1, 300, "kN")


CURVES = (
    "distance tip to ground__D",
    "distance x_A y_A to tip",
    "distance tip to x_A y_A",
    'clearance tip over "a b.csv"',
    'clearance tip over "soil"',
    "distance x_tip y_tip to a/b.csv",
    "distance distance at to 'a \"b.csv'",
    'distance x y to "it\'s.csv"',
)


def random_measure(rng: random.Random) -> Measure:
    def name() -> str:
        return rng.choice(["F_Ox", "s", "min", "y_tip", "range", "P_m2", "distance", *CURVES])

    def number() -> float:
        return rng.choice([1.0, -2.5, rng.uniform(-1e9, 1e9), rng.gauss(0, 1e-7), 0.0])

    def condition() -> MeasureCondition:
        unit = rng.choice(["", "mm", "N m", "m/s2", "r/min", "kg m2", "%"])
        return MeasureCondition(
            name(), rng.choice([1, -1]), number(), unit, rng.random() < 0.3, rng.random() < 0.3
        )

    measure = Measure(rng.choice([*KINDS, "all"]), name(), rng.random() < 0.4)
    match rng.randrange(4):
        case 0:
            return dataclasses.replace(measure, kind="at", angle=number())
        case 1:
            return dataclasses.replace(
                measure, kind="at", where=Extremum(name(), rng.choice([1, -1]))
            )
        case 2:
            return dataclasses.replace(
                measure, during=tuple(condition() for _ in range(rng.randint(1, 3)))
            )
    return measure


def test_text_reads_back_to_the_same() -> None:
    rng, limits, sums = random.Random(5), 0, 0
    for _ in range(600):
        measure, unit = random_measure(rng), rng.choice(["", "N", "mm/s2"])
        limit = Limit(measure, rng.choice([1, -1]), rng.gauss(0, 100), unit)
        with contextlib.suppress(InputError):
            assert parse_limit(str(limit)) == limit
            limits += 1
        sign = -1 if measure.kind == "min" else 1
        weighted = dataclasses.replace(measure, weight=sign * abs(rng.gauss(0, 10)))
        with contextlib.suppress(InputError):
            assert parse_sum(format_sum([weighted, weighted])) == (weighted, weighted)
            sums += 1
    assert min(limits, sums) > 300, "what has no corners is no limit, or no sum"


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("rang F_Ox", ["'rang' at character 1", "did you mean range?"]),
        ("max F + avs rms F", ["'avs' at character 9", "no measure"]),
        ("max F whle y < 3", ["'whle' at character 7", "did you mean while?"]),
        ("F where y is leas", ["'leas' at character 14", "did you mean least?"]),
        ("max F at 30", ["'at' at character 7", "max"]),
        ("mean F while y", ["the end", "NAME <= NUMBER"]),
        ("mean F while y <= 3 mn", ["'mn' at character 21", "not a unit"]),
        ("mean F while y <= three", ["'three' at character 19", "no number"]),
        ("max F +", ["the end"]),
        ("", ["the end"]),
        ("F", ["F needs a measure"]),
        ("std abs F", ["std takes no abs"]),
        ("-1 max s", ["max s can only be made smaller"]),
        ("max F - range s", ["range s can only be made smaller"]),
        ("min s", ["write -min s"]),
        ("range abs s", ["range takes no abs"]),
        ("max distanc x y to p.csv", ["'distanc' at character 5", "did you mean distance?"]),
        ("max distance to p.csv", ["'to' at character 14", "distance is one of POINT to FILE"]),
        ("max distance x y two p.csv", ["'two' at character 18", "did you mean to?"]),
        ("max distance x y to", ["the end is no file"]),
        ("max distance x y to 'p.csv", ['"\'" at character 21', "opens a quote"]),
        ("-jump s", ["jump s can only be made smaller"]),
        ("jump abs s", ["'abs' at character 6", "jump, which is a size"]),
        ("jump F while s <= 3", ["'while' at character 8", "does not go with jump"]),
        ("jump F at 30", ["'at' at character 8"]),
    ],
)
def test_refusal_names_word_and_character(text: str, parts: list[str]) -> None:
    with pytest.raises(InputError) as caught:
        parse_sum(text, "file.toml: objective.least")
    assert caught.value.message.startswith(f"file.toml: objective.least {text!r}:")
    assert all(part in caught.value.message for part in parts), caught.value.message


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("F < 3", "'<' at character 3"),
        ("F", "a limit is missing"),
        ("2 max F <= 3", "'2' at character 1"),
        ("abs F >= 3", "abs"),
        ("jump F >= 3", "jump <="),
        ("F <= 3 parsecs", "parsecs"),
        ("F <= 3 <= 4", "character 8"),
        ("mean F while y <= 3", "a limit is missing"),
    ],
)
def test_invalid_limit_is_refused(text: str, part: str) -> None:
    with pytest.raises(InputError, match=": ") as caught:
        parse_limit(text)
    assert part in caught.value.message


def test_times_are_read_in_seconds() -> None:
    assert parse_measure("x at 2 s", "number 1") == Measure("at", "x", angle=2, in_time=True)
    (term,) = parse_sum("max abs x over 0.5..2 s while y >= 1")
    assert (term.span, str(term)) == ((0.5, 2.0), "max abs x over 0.5..2 s while y >= 1")
    with pytest.raises(InputError, match="ends after"):
        parse_limit("max x over 2..1 s <= 3")
