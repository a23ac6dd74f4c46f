"""A model as C99: x' = f(t, x, u, p), y = g(t, x, u, p) and their derivatives, without a heap."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence

import casadi as ca

from planter.exports.c99 import (
    join_numbers,
    list_lines,
    quote_strings,
    read_template,
    to_plain,
    wrap_comment,
)
from planter.mechanism.state_space.model import DynamicsModel, DynamicsVariable
from planter.version import __version__

FUNCTIONS = {
    "rates": "f",
    "rates_jacobian": "f_jacobian",
    "outputs_at": "y",
    "outputs_jacobian": "y_jacobian",
}
"""Functions in C, with those of the model."""


def build_c_files(model: DynamicsModel) -> dict[str, str]:
    """Return the texts by file name: `NAME.h`, `NAME.c`, `NAME_main.c`."""
    name = build_name(model)
    functions = {
        label: densify_by_rows(label, getattr(model, member)) for label, member in FUNCTIONS.items()
    }
    fields = {**_describe(model, name), **_list_values(model)}
    fields["operations"] = list_lines(
        "Operations and numbers on the stack:",
        (f"{name}_{label}: {f.n_instructions()}, {f.sz_w()}" for label, f in functions.items()),
    )
    fields["helpers"], fields["graphs"] = _print_graphs(functions)
    bodies = [_print_function(name, label, f) for label, f in functions.items()]
    fields["functions"] = "\n\n".join(bodies)
    targets = {
        f"{name}.h": "dynamics.h",
        f"{name}.c": "dynamics.c",
        f"{name}_main.c": "dynamics_main.c",
    }
    return {file: read_template(template).substitute(fields) for file, template in targets.items()}


def build_name(model: DynamicsModel) -> str:
    """Return the name of files and functions."""
    return re.sub(r"\W+", "_", model.dynamics.file.functions)


def densify_by_rows(label: str, function: ca.Function) -> ca.Function:
    """Return a function whose matrices are dense, row by row."""
    symbols = function.sx_in()
    graphs = [ca.densify(graph).T for graph in function.call(symbols)]
    return ca.Function(label, symbols, graphs, function.name_in(), function.name_out())


def _describe(model: DynamicsModel, name: str) -> dict[str, object]:
    parts = {
        "x": model.states,
        "u": model.inputs,
        "p": model.parameters,
        "y": model.outputs,
    }
    lines = [
        list_lines(f"{symbol}:", _list_variables(symbol, variables))
        for symbol, variables in parts.items()
    ]
    names = ", ".join(model.constraints) or "none"
    constraints = f"Constraints: {names}."
    if model.left_out:
        constraints += f" These follow from them: {', '.join(model.left_out)}."
    sizes = map(len, parts.values())
    return {
        "name": name,
        "NAME": name.upper(),
        "version": __version__,
        "headline": to_plain(f"The dynamics of {model.name}"),
        "variables": "\n".join(lines),
        "constraints": wrap_comment(constraints),
        **dict(zip(("states", "inputs", "parameters", "outputs"), sizes, strict=True)),
    }


def _list_variables(symbol: str, variables: Sequence[DynamicsVariable]) -> Iterator[str]:
    for index, variable in enumerate(variables):
        yield f"{symbol}[{index}] {variable.name} [{variable.unit}] {variable.meaning}"


def _list_values(model: DynamicsModel) -> dict[str, str]:
    names = {
        "state": model.states,
        "input": model.inputs,
        "parameter": model.parameters,
        "output": model.outputs,
    }
    quoted = {
        f"{key}_names": quote_strings(variable.name for variable in variables) or '""'
        for key, variables in names.items()
    }
    values = {"start": model.start, "u": model.u, "p": model.p}
    return quoted | {key: join_numbers(numbers) for key, numbers in values.items()}


def _print_graphs(functions: Mapping[str, ca.Function]) -> tuple[str, str]:
    """Return CasADi's C of helpers, and of functions `NAME_graph(arg, res)`."""
    generator = ca.CodeGenerator("graphs.c", {"casadi_real": "real"})
    for function in functions.values():
        generator.add(function)
    text = str(generator.dump())
    bodies = []
    for label in functions:
        body = re.search(
            rf"/\* {label}:\(.*?\*/\nstatic int \w+\([^)]*\) {{\n(.*?)\n}}\n", text, re.DOTALL
        )
        assert body is not None
        head = f"static void {label}_graph(const real **arg, real **res) {{"
        bodies.append(f"{head}\n{body[1].replace('  return 0;', '').rstrip()}\n}}")
    start = text.index("\n#endif\n", text.index("#ifndef CASADI_SYMBOL_EXPORT"))
    helpers = text[start + 8 : text.index("/* Configuration")]
    joined = "\n\n".join([helpers, *bodies]).replace("casadi_real", "real")
    joined = re.sub(r"^(?=real casadi_)", "static ", joined, flags=re.MULTILINE)
    end = joined.index("static void")
    return joined[:end].strip(), joined[end:].strip()


def _print_function(name: str, label: str, function: ca.Function) -> str:
    results = function.name_out()
    head = ", ".join(f"{name}_real *{result}" for result in results)
    checks = "".join(
        f"  if (!status) status = check_results({result}, {function.numel_out(index)});\n"
        for index, result in enumerate(results)
    )
    return (
        f"int {name}_{label}({name}_real t, const {name}_real *x, const {name}_real *u, "
        f"const {name}_real *p,\n    {head}) {{\n"
        "  const real *arg[4];\n"
        f"  real *res[{len(results)}];\n"
        "  int status = check_inputs(x, u, p);\n"
        "  if (status) return status;\n"
        "  arg[0] = &t, arg[1] = x, arg[2] = u, arg[3] = p;\n"
        + "".join(f"  res[{index}] = {result};\n" for index, result in enumerate(results))
        + f"  {label}_graph(arg, res);\n{checks}  return status;\n}}"
    )
