"""CasADi's external C interface for a lane kernel with a fixed number of lanes, printed beside the raw loop.

A solver of CasADi's can then call the loop without Python. Matrices are column-major there, so inputs and outputs that
vary are (lanes, rows).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import casadi as ca

from planter.kernels.loops.source import prototype

Shape = tuple[int, int]


def name(function: ca.Function, lanes: int) -> str:
    """The name of the external function."""
    return f"{function.name()}_{lanes}"


def source(f: ca.Function, varies: Sequence[str], summed: bool, lanes: int) -> str:
    """A C file with the interface of a function whose inputs `varies` vary; the raw loop is linked to it."""
    own = name(f, lanes)
    varying = [n in varies for n in f.name_in()]
    inputs = [(lanes, f.numel_in(i)) if column else f.size_in(i) for i, column in enumerate(varying)]
    outputs = [(1 if summed else lanes, f.numel_out(i)) for i in range(f.n_out())]
    return "\n".join([
        "typedef long long casadi_int;", "",
        f"{prototype(f)};", "",
        _evaluation(f.name(), own, lanes, len(inputs), outputs),
        _sparsities(own, "in", inputs), _sparsities(own, "out", outputs),
        _names(own, "in", f.name_in()), _names(own, "out", f.name_out()),
    ])  # fmt: skip


def _evaluation(raw: str, own: str, lanes: int, inputs: int, outputs: Sequence[Shape]) -> str:
    """The call; a result that is not wanted, a null pointer, goes to working memory."""
    places, offset = [], 0
    for index, (rows, columns) in enumerate(outputs):
        places.append(f"res[{index}] ? res[{index}] : w + {offset}")
        offset += rows * columns
    arguments = [str(lanes), *(f"arg[{i}]" for i in range(inputs)), *places]
    return f"""\
int {own}(const double **arg, double **res, casadi_int *iw, double *w, int mem)
{{
  (void)iw;
  (void)mem;
  {raw}({", ".join(arguments)});
  return 0;
}}
casadi_int {own}_n_in(void) {{ return {inputs}; }}
casadi_int {own}_n_out(void) {{ return {len(outputs)}; }}
int {own}_work(casadi_int *sz_arg, casadi_int *sz_res, casadi_int *sz_iw, casadi_int *sz_w)
{{
  if (sz_arg) *sz_arg = {inputs};
  if (sz_res) *sz_res = {len(outputs)};
  if (sz_iw) *sz_iw = 0;
  if (sz_w) *sz_w = {offset};
  return 0;
}}
"""


def _sparsities(own: str, side: str, shapes: Iterable[Shape]) -> str:
    """Every matrix is dense, which CasADi writes as rows, columns, 1."""
    rows = ", ".join(f"{{{rows}, {columns}, 1}}" for rows, columns in shapes)
    return f"""\
const casadi_int *{own}_sparsity_{side}(casadi_int i)
{{
  static const casadi_int shapes[][3] = {{{rows}}};
  return shapes[i];
}}"""


def _names(own: str, side: str, names: Iterable[str]) -> str:
    quoted = ", ".join(f'"{name}"' for name in names)
    return f"""\
const char *{own}_name_{side}(casadi_int i)
{{
  static const char *const names[] = {{{quoted}}};
  return names[i];
}}"""
