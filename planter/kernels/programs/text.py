"""Programs as C99: a file of loops over lanes, and one of CasADi's own C with what calls both.

double *NAME_numbers(void);    its numbers, one vector after another; what is given is set to what it was at first
int NAME(void);                runs it on them; other than zero where one is not finite
"""

from __future__ import annotations

from collections.abc import Sequence
from importlib import resources
from string import Template

import casadi as ca

from planter.kernels import loops
from planter.kernels.programs.program import Program, Step

LOOPS, MAIN = "loops.c", "programs.c"


def texts(programs: Sequence[Program]) -> dict[str, str]:
    """The texts by file name. Raises NotPrintable where a function over lanes has no such form."""
    steps = [step for program in programs for step in program.steps]
    graphs = [loops.Graph.of(step.function, step.lanes) for step in steps if step.lanes]
    return {LOOPS: loops.file(graphs, [False] * len(graphs), wasm=True), MAIN: _main(programs, steps)}


def _main(programs: Sequence[Program], steps: Sequence[Step]) -> str:
    generator = ca.CodeGenerator("planter.c")
    for step in steps:
        if not step.lanes:
            generator.add(step.function)
    whole = [step.function for step in steps if not step.lanes]
    work = {key: max((int(getattr(f, f"sz_{key}")()) for f in whole), default=0) + 1
            for key in ("arg", "res", "iw", "w")}  # fmt: skip
    text = resources.files(__package__).joinpath("program.c").read_text(encoding="utf-8")
    prototypes = "\n".join(f"{loops.prototype(step.function)};" for step in steps if step.lanes)
    head = Template(text).substitute(work, functions=str(generator.dump()), prototypes=prototypes)
    return "\n".join([head, *map(_program, programs)])


def _program(program: Program) -> str:
    own = f"{program.name}_numbers"
    place = {name: f"{program.name}_all + {offset}" for name, offset in program.offsets.items()}
    start = [repr(float(value)) for vector in program.given.values() for value in vector]
    given = len(start)
    return "\n".join([
        f"static double {program.name}_all[{program.size}];", "",
        f"double *{own}(void)", "{",
        f"  static const double start[{given}] = {{{', '.join(start)}}};",
        f"  memcpy({program.name}_all, start, sizeof start);",
        f"  return {program.name}_all;", "}", "",
        f"int {program.name}(void)", "{", *(_call(program, step, place) for step in program.steps),
        f"  return any_not_finite({program.name}_all + {given}, {program.size - given});", "}", "",
    ])  # fmt: skip


def _call(program: Program, step: Step, place: dict[str, str]) -> str:
    f = step.function
    inputs, outputs = ([place[name] for name in names] for names in (f.name_in(), f.name_out()))
    if step.lanes:
        return f"  {f.name()}({', '.join([str(program.count(step)), *inputs, *outputs])});"
    given = [f"arg[{index}] = {at};" for index, at in enumerate(inputs)]
    taken = [f"res[{index}] = {at};" for index, at in enumerate(outputs)]
    return f"  {' '.join([*given, *taken])}\n  if ({f.name()}(arg, res, iw, w, 0)) return 1;"
