"""Presentation of a benchmark: for a terminal, and in Markdown for docs/performance.md."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path

from planter.bench.results import ArithmeticPeak, Benchmark, TaskTimes, WayTimes
from planter.report import bundle
from planter.report.html import Block, Items, Section, Table, Text
from planter.report.presentation import ResultPresentation

CYCLE_TASKS = ("cycle", "cycle+gradient", "hessian", "batch", "slider-crank", "four-bar")
WAY_HEAD = ("way", "median / us", "quartiles / us", "calls", "ratio", "disagreement")
SEED_HEAD = ("seed", "GA: objective", "GA / s", "IPOPT: objective", "IPOPT / s", "starts", "met")
RATE_HEAD = ("work", "way", "operations", "operations per cycle", "share of the peak")


def present_benchmark(result: Benchmark) -> ResultPresentation:
    """Return the presentation of a benchmark: a summary, every task, its omissions, and the
    machine.
    """
    return ResultPresentation(
        title="Benchmark", record=result, sections=list(_list_sections(result))
    )


def format_markdown(result: Benchmark) -> str:
    """Return a benchmark in Markdown."""
    parts = []
    for section in _list_sections(result):
        parts += [f"## {section.title}", *map(_format_block, section.blocks)]
    return "\n\n".join(parts) + "\n"


def write_benchmark(folder: Path, result: Benchmark) -> None:
    """Write bench.json, and bench.md, the tables of docs/performance.md.

    Raises InputError if the folder cannot be written.
    """
    content = json.dumps(result.table(), indent=2, allow_nan=False) + "\n"
    bundle.write_bundle(folder, {"bench.json": content, "bench.md": format_markdown(result)}, {})


def _format_block(block: Block) -> str:
    match block:
        case Table():
            lines = [block.head, ["---", *["---:"] * (len(block.head) - 1)], *block.rows]
            return "\n".join(f"| {' | '.join(map(str, line))} |" for line in lines)
        case Items():
            return "\n".join(f"* {item}" for item in block.items)
        case Text():
            return block.text
    raise TypeError(f"{type(block).__name__} has no Markdown")


def _list_sections(result: Benchmark) -> Iterator[Section]:
    yield Section("Summary", [_summarise(result)])
    for work in result.work:
        yield Section(
            f"{work.name} [{work.unit}; ratio over {work.over}]", list(_list_task_blocks(work))
        )
    if result.arithmetic is not None:
        yield Section("Arithmetic", list(_list_rate_blocks(result.arithmetic, result.vector_width)))
    built = [
        f"{work.name}, {way.way}: {way.built}"
        for work in result.work
        for way in (*work.ways, *work.variants)
    ]
    yield Section("How each way was built", [Items(built)])
    omissions = [f"{entry.work}: skipped, {entry.reason}" for entry in result.skipped]
    omissions += [
        f"{work.name}, {way.way}: skipped, {way.reason}"
        for work in result.work
        for way in work.skipped
    ]
    yield Section("Left out", [Items(omissions) if omissions else Text("Nothing.")])
    surroundings = {
        **result.machine.table(),
        **result.versions,
        "device": result.device,
        "samples": result.samples,
        "seconds in all": round(result.seconds),
    }
    yield Section(
        "Where it ran", [Items([f"{name}: {value}" for name, value in surroundings.items()])]
    )


def _summarise(result: Benchmark) -> Table:
    """Return the table of the medians of the tasks on a cycle, each with its ratio, a row for each
    way.
    """
    tasks = {
        task.name: {way.way: way for way in task.ways}
        for task in result.work
        if task.name in CYCLE_TASKS
    }
    names = dict.fromkeys(name for ways in tasks.values() for name in ways)
    rows = [(name, *(_format_median(ways.get(name)) for ways in tasks.values())) for name in names]
    return Table(("way", *(f"{task} / us (ratio)" for task in tasks)), rows)


def _format_median(way: WayTimes | None) -> str:
    return f"{_format_time(way.median_us)} ({way.ratio:.3g})" if way else ""


def _list_task_blocks(work: TaskTimes) -> Iterator[Block]:
    """Yield the times of all ways, the search for the best of several basins, and the deviation of
    drawn gears.
    """
    yield Table(WAY_HEAD, [_tabulate_way(way) for way in (*work.ways, *work.variants)])
    if work.exact is not None:
        rows = [
            (
                str(s.seed),
                f"{s.ga_objective:.6f}",
                f"{s.ga_s:.2f}",
                f"{s.ipopt_objective:.6f}",
                f"{s.ipopt_s:.2f}",
                str(s.starts),
                "yes" if s.met else "no",
            )
            for s in work.exact.seeds
        ]
        yield Text(
            "The exact model has several basins: time and starts until IPOPT meets what the GA "
            "found."
        )
        yield Table(SEED_HEAD, rows)
    sentences = [
        f"{way.way} draws {way.drawn.vertices} vertices, {way.drawn.deviation_um:.2g} um off at "
        f"most"
        for way in work.ways
        if way.drawn is not None
    ]
    if sentences:
        yield Text(f"{'; '.join(sentences)}.")


def _tabulate_way(way: WayTimes) -> Sequence[str]:
    low, high = map(_format_time, (way.spread.quartile1_us, way.spread.quartile3_us))
    disagreement = "" if way.disagreement is None else f"{way.disagreement:.1g}"
    median = _format_time(way.median_us)
    return (
        way.way,
        median,
        f"{low} to {high}",
        str(way.spread.calls),
        f"{way.ratio:.3g}",
        disagreement,
    )


def _format_time(value: float) -> str:
    """
    >>> _format_time(9.512), _format_time(8467.8), _format_time(1234567.8)
    ('9.51', '8 470', '1 230 000')
    """
    rounded = float(f"{value:.3g}")
    return f"{rounded:,.0f}".replace(",", " ") if rounded >= 100 else f"{rounded:g}"


def _list_rate_blocks(arithmetic: ArithmeticPeak, width: int | None) -> Iterator[Block]:
    yield Text(
        f"Peak of one core, measured: {arithmetic.peak_operations_per_cycle:.1f} operations per "
        f"cycle "
        f"(vectors of {width} bits, a fused multiply-add is two) at {arithmetic.clock_GHz:.2f} GHz"
    )
    rows = [
        (
            rate.work,
            rate.way,
            str(rate.operations),
            f"{rate.operations_per_cycle:.2f}",
            f"{rate.share_of_peak:.1%}",
        )
        for rate in arithmetic.rates
    ]
    yield Table(RATE_HEAD, rows)
