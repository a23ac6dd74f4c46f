"""A benchmark as tables: for a terminal, and in Markdown for docs/performance.md."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path

from planter.bench.results import Arithmetic, Benchmark, Rate, Way, Work
from planter.report import files
from planter.report.folder import renewing
from planter.terminal.console import Console

TURNS = ("cycle", "cycle+gradient", "hessian", "batch", "slider-crank", "four-bar")
HEADER = ("way", "median / us", "quartiles / us", "calls", "ratio", "disagreement")


def show(console: Console, result: Benchmark) -> None:
    """The tables on a terminal."""
    for work in result.work:
        console.table(_title(work), HEADER, _rows(work))
        for line in _drawing_lines(work):
            print(f"{line}\n")
    if result.arithmetic:
        console.table(_peak(result.arithmetic, result.vector_width), RATES, _rates(result.arithmetic))
    for line in _left_out(result):
        print(line)


def markdown(result: Benchmark) -> str:
    """The page in Markdown: summary, every work, what was left out, where it ran."""
    parts = ["## Summary", _summary(result)]
    for work in result.work:
        parts += [f"## {_title(work)}", _markdown(HEADER, _rows(work)), *_exact(work), *_drawing_lines(work)]
    if result.arithmetic:
        parts += ["## Arithmetic", _peak(result.arithmetic, result.vector_width),
                  _markdown(RATES, _rates(result.arithmetic))]  # fmt: skip
    parts += ["## How each way was built", "\n".join(_built(result))]
    parts += ["## Left out", "\n".join(f"* {line}" for line in _left_out(result)) or "Nothing."]
    parts += ["## Where it ran", "\n".join(f"* {name}: {value}" for name, value in _surroundings(result))]
    return "\n\n".join(parts) + "\n"


def write_benchmark(folder: str | Path, result: Benchmark) -> None:
    """Write bench.json, and bench.md, the tables of docs/performance.md.

    Raises InputError if the folder cannot be written.
    """
    with renewing(folder):
        place = files.output_folder(folder)
        files.write_text(place / "bench.json", json.dumps(result.table(), indent=2, allow_nan=False) + "\n")
        files.write_text(place / "bench.md", markdown(result))


def _title(work: Work) -> str:
    return f"{work.name} [{work.unit}; ratio over {work.over}]"


def _rows(work: Work) -> list[Sequence[str]]:
    return [_row(way) for way in (*work.ways, *work.variants)]


def _row(way: Way) -> Sequence[str]:
    low, high = map(_time, (way.spread.quartile1_us, way.spread.quartile3_us))
    off = f"{way.disagreement:.1g}" if way.disagreement is not None else ""
    return (way.way, _time(way.median_us), f"{low} to {high}", str(way.spread.calls), _ratio(way), off)


def _ratio(way: Way) -> str:
    return f"{way.ratio:.3g}"


def _time(value: float) -> str:
    """
    >>> _time(9.512), _time(8467.8), _time(1234567.8)
    ('9.51', '8 470', '1 230 000')
    """
    rounded = float(f"{value:.3g}")
    return f"{rounded:,.0f}".replace(",", " ") if rounded >= 100 else f"{rounded:g}"


def _summary(result: Benchmark) -> str:
    """Medians of a turn's works, each with its ratio, a row for each way."""
    works = [work for work in result.work if work.name in TURNS]
    named = {work.name: {way.way: way for way in work.ways} for work in works}
    ways = list(dict.fromkeys(way for row_ways in named.values() for way in row_ways))
    rows = [(way, *(_with_ratio(row_ways.get(way)) for row_ways in named.values())) for way in ways]
    return _markdown(("way", *(f"{work.name} / us (ratio)" for work in works)), rows)


def _with_ratio(way: Way | None) -> str:
    return f"{_time(way.median_us)} ({_ratio(way)})" if way else ""


def _exact(work: Work) -> Iterator[str]:
    """Yield the table of the times until IPOPT meets the genetic algorithm in the exact model."""
    if work.exact is not None:
        header = ("seed", "GA: objective", "GA / s", "IPOPT: objective", "IPOPT / s", "starts", "met")
        rows = [
            (str(s.seed), f"{s.ga_objective:.6f}", f"{s.ga_s:.2f}", f"{s.ipopt_objective:.6f}",
             f"{s.ipopt_s:.2f}", str(s.starts), "yes" if s.met else "no") for s in work.exact.seeds
        ]  # fmt: skip
        yield "The exact model has several basins: time and starts until IPOPT meets what the GA found."
        yield _markdown(header, rows)


def _drawing_lines(work: Work) -> Iterator[str]:
    """Yield the number of vertices and the deviation of the drawn gears."""
    sentences = [f"{way.way} draws {way.drawn.vertices} vertices, {way.drawn.deviation_um:.2g} um off at most"
            for way in work.ways if way.drawn is not None]  # fmt: skip
    if sentences:
        yield f"{'; '.join(sentences)}."


RATES = ("work", "way", "operations", "operations per cycle", "share of the peak")


def _peak(arithmetic: Arithmetic, width: int | None) -> str:
    return (
        f"Peak of one core, measured: {arithmetic.peak_operations_per_cycle:.1f} operations per cycle "
        f"(vectors of {width} bits, a fused multiply-add is two) at {arithmetic.clock_GHz:.2f} GHz"
    )


def _rates(arithmetic: Arithmetic) -> list[Sequence[str]]:
    return [_rate(row) for row in arithmetic.rates]


def _rate(row: Rate) -> Sequence[str]:
    speed, share = f"{row.operations_per_cycle:.2f}", f"{row.share_of_peak:.1%}"
    return (row.work, row.way, str(row.operations), speed, share)


def _built(result: Benchmark) -> Iterator[str]:
    for work in result.work:
        yield from (f"* {work.name}, {way.way}: {way.built}" for way in (*work.ways, *work.variants))


def _left_out(result: Benchmark) -> Iterator[str]:
    for entry in result.skipped:
        yield f"{entry.work}: skipped, {entry.reason}"
    for work in result.work:
        yield from (f"{work.name}, {entry.way}: skipped, {entry.reason}" for entry in work.skipped)


def _surroundings(result: Benchmark) -> Iterator[tuple[str, object]]:
    yield from result.machine.table().items()
    yield from result.versions.items()
    yield from (("device", result.device), ("samples", result.samples))
    yield "seconds in all", round(result.seconds)


def _markdown(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [header, ["---", *["---:"] * (len(header) - 1)], *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)
