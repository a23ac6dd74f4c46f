"""The works: who takes part, agreement, then the clock; each ends as a table for JSON."""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from planter.bench import graphs, jaxed, lanes, mechanisms, outlines, plain, processes, searches, symbolic
from planter.bench.case import Absent, Case, Contender
from planter.bench.clock import Times, agree, race
from planter.bench.results import Reached, Skipped, Way, Work
from planter.bench.settings import WAYS, Settings
from planter.kernels import Array

Builder = Callable[[Case, str], Contender]
Built = Mapping[str, str]

BUILDERS: dict[str, Builder] = {
    "numpy": plain.contender,
    "lambdify": symbolic.contender,
    "jax": jaxed.contender,
    "casadi-vm": graphs.virtual_machine,
    "casadi-c": graphs.own_c,
    "lanes": lanes.contender,
}
VARIANTS: dict[str, Builder] = {"numpy, steps in one array": plain.together, "casadi-c, -ffast-math": graphs.own_c_fast}
"""Other settings of the peers, timed beside them where they do the work."""
CHECKED = 5
"""Designs at which the ways must agree."""
UNITS = {
    "cycle": "us per turn: objective",
    "cycle+gradient": "us per turn: objective and gradient",
    "hessian": "us per turn: Hessian of the objective",
    "optimise": "us per optimisation of the printed model",
    "gears": outlines.UNIT,
    "derive": "us per derivation, all of generated/",
    "cold start": "us per new process",
}


def run(name: str, case: Case, settings: Settings) -> Work:
    """One work. Raises Absent where it cannot be done here, Disagreement where a way is wrong."""
    if name in ("cycle", "cycle+gradient", "hessian"):
        return _turn(name, case, settings)
    if name == "batch":
        return _batch(case, settings)
    if name == "optimise":
        return _optimise(case, settings)
    if name == "gears":
        return _gears(case, settings)
    if name in mechanisms.EXAMPLES:
        return _mechanism(name, settings)
    return _derive(settings) if name == "derive" else _cold_start(settings)


def _turn(name: str, case: Case, settings: Settings) -> Work:
    """A new design at every call, through what each way calls its public function."""
    contenders, skipped = list_contenders(name, case, settings)
    designs = case.designs()
    off = agree(name, contenders, [next(designs) for _ in range(CHECKED)])
    calls = {way: contender.call for way, contender in contenders.items()}
    times = race(calls, designs, settings.rounds, settings.slot_s)
    return table(name, times, "lanes", {way: c.built for way, c in contenders.items()}, off, skipped)


def _batch(case: Case, settings: Settings) -> Work:
    contenders, skipped = list_contenders("batch", case, settings)
    rng = np.random.default_rng(0)

    def inputs() -> Iterator[Array]:
        while True:
            yield case.draw_designs(rng, settings.designs)

    off = agree("batch", contenders, [next(inputs())])
    times = race({way: c.call for way, c in contenders.items()}, inputs(), settings.batches, 0)
    built = {way: c.built for way, c in contenders.items()}
    unit = f"us per {settings.designs} designs: their objectives, {os.cpu_count()} cores"
    return replace(table("batch", times, "lanes", built, off, skipped), unit=unit)


def _optimise(case: Case, settings: Settings) -> Work:
    times, reached = searches.printed(case, settings.searches)
    work = table("optimise", times, searches.REFERENCE, searches.BUILT)
    ways = [replace(w, objectives=Reached(min(reached[w.way]), max(reached[w.way]))) for w in work.ways]
    return replace(work, ways=ways, exact=None if settings.quick else searches.exact(case, settings.searches))


def _gears(case: Case, settings: Settings) -> Work:
    ways, skipped = outlines.ways(case)
    times = race({name: way.make for name, way in ways.items()}, _nothing(), settings.pairs, 0)
    work = table("gears", times, "planter", {name: way.built for name, way in ways.items()}, skipped=skipped)
    return replace(work, ways=[replace(row, drawn=ways[row.way].measure()) for row in work.ways])


def _mechanism(name: str, settings: Settings) -> Work:
    """Measure a user-defined mechanism, and the time from its statement to functions."""
    with tempfile.TemporaryDirectory(prefix="planter-") as folder:
        begun = time.perf_counter()
        case = mechanisms.MechanismCase(name, Path(folder))
        seconds = time.perf_counter() - begun
        contenders: dict[str, Contender] = {}
        skipped: list[Skipped] = []
        for way, builder in mechanisms.BUILDERS.items():
            try:
                if way not in settings.ways:
                    raise Absent("not asked for (--way)")
                contenders[way] = builder(case)
            except Absent as reason:
                skipped.append(Skipped(way, str(reason)))
        designs = case.designs()
        off = agree(name, contenders, [next(designs) for _ in range(CHECKED)])
        calls = {way: contender.call for way, contender in contenders.items()}
        times = race(calls, designs, settings.rounds, settings.slot_s)
        built = {way: c.built for way, c in contenders.items()}
    unit = (
        f"us per turn of {mechanisms.ANGLES} angles: mean square of the torque and gradient; derived in {seconds:.2f} s"
    )
    return replace(table(name, times, "lanes", built, off, skipped), unit=unit)


def _derive(settings: Settings) -> Work:
    with processes.derivation() as start:
        times = race({"derive": start}, _nothing(), settings.derivations, 0)
    return table("derive", times, "derive", {"derive": "python -m derive, in a copy of the checkout"})


def _cold_start(settings: Settings) -> Work:
    with processes.cold_starts() as (starts, built):
        times = race(starts, _nothing(), settings.processes, 0)
    return table("cold start", times, "lanes", built)


def _nothing() -> Iterator[None]:
    while True:
        yield None


def list_contenders(name: str, case: Case, settings: Settings) -> tuple[dict[str, Contender], list[Skipped]]:
    """Return the ways of a work, CasADi's virtual machine first, and those left out, with the reason."""
    contenders: dict[str, Contender] = {}
    skipped: list[Skipped] = []
    variants = {} if settings.quick or settings.ways != WAYS else VARIANTS
    for way, builder in {**BUILDERS, **variants}.items():
        try:
            if way not in settings.ways and way not in variants:
                raise Absent("not asked for (--way)")
            contenders[way] = _thrifty(case, name) if way == "jax" and settings.quick else builder(case, name)
        except Absent as reason:
            if way not in variants:
                skipped.append(Skipped(way, str(reason)))
    return dict(sorted(contenders.items(), key=lambda item: item[0] != "casadi-vm")), skipped


def _thrifty(case: Case, name: str) -> Contender:
    """JAX in one form alone, since each takes it seconds to compile."""
    return jaxed.contender(case, name, thorough=False)


def table(
    name: str,
    times: Mapping[str, Times],
    over: str,
    built: Built,
    off: Mapping[str, float] | None = None,
    skipped: list[Skipped] | None = None,
) -> Work:
    """A work as the interface gives it: ratios over the way `over`, or over the first where that is not there."""
    reference = over if over in times else next(iter(times))
    rows = [
        Way(way, taken.median_us, taken.median_us / times[reference].median_us, taken.spread(), built[way],
            off[way] if off else None)
        for way, taken in times.items()
    ]  # fmt: skip
    order = (*WAYS, *times)
    rows.sort(key=lambda row: order.index(row.way))
    ways, variants = ([r for r in rows if (r.way in VARIANTS) is other] for other in (False, True))
    return Work(name, UNITS.get(name, ""), reference, ways, variants, skipped or [])
