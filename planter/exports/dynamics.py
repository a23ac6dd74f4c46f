"""Models of free motion for other languages: x' = f(t, x, u, p), y = g(t, x, u, p), derivatives.

C99 without a heap and CasADi's functions keep the graphs of the model; Rust and JAX have one scalar
operation a line, printed by a dialect, JAX equal bodies in loops.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence

import casadi as ca

from planter.exports.c99 import (
    join_numbers,
    list_lines,
    quote_strings,
    read_template,
    to_plain,
    wrap_comment,
)
from planter.exports.dialect import RUST
from planter.exports.jax_module import HELPERS, IMPORTS, JaxPrinter
from planter.kernels.lane_graph import LaneGraph
from planter.mechanism.state_space.model import DynamicsModel, DynamicsVariable
from planter.version import __version__

FUNCTIONS = {
    "rates": "f",
    "rates_jacobian": "f_jacobian",
    "outputs_at": "y",
    "outputs_jacobian": "y_jacobian",
}
"""Functions in C, with those of the model."""


def build_name(model: DynamicsModel) -> str:
    """Return the name of files and functions."""
    return re.sub(r"\W+", "_", model.dynamics.file.functions)


def _group_variables(model: DynamicsModel) -> dict[str, Sequence[DynamicsVariable]]:
    """Return all variables by what they are."""
    return {
        "states": model.states,
        "inputs": model.inputs,
        "parameters": model.parameters,
        "outputs": model.outputs,
    }


def _describe_variables(symbol: str, variables: Sequence[DynamicsVariable]) -> list[str]:
    """Return a line for each element of a vector."""
    texts = (f"{x.name} [{x.unit}] {x.meaning}" for x in variables)
    return [f"{symbol}[{i}] {to_plain(text)}" for i, text in enumerate(texts)]


def _densify(model: DynamicsModel, label: str) -> ca.Function:
    """Return a function of the model whose matrices are dense, row by row."""
    function = getattr(model, FUNCTIONS[label])
    symbols = function.sx_in()
    graphs = [ca.densify(graph).T for graph in function.call(symbols)]
    return ca.Function(label, symbols, graphs, function.name_in(), function.name_out())


# --- C -------------------------------------------------------------------------------------------


def build_c_files(model: DynamicsModel) -> dict[str, str]:
    """Return the texts by file name: `NAME.h`, `NAME.c`, `NAME_main.c`."""
    name = build_name(model)
    functions = {label: _densify(model, label) for label in FUNCTIONS}
    operations = (
        f"{name}_{label}: {f.n_instructions()}, {f.sz_w()}" for label, f in functions.items()
    )
    helpers, graphs = _print_graphs(functions)
    bodies = [_print_c(name, label, function) for label, function in functions.items()]
    constraints = f"Constraints: {', '.join(model.constraints) or 'none'}."
    if model.left_out:
        constraints += f" These follow from them: {', '.join(model.left_out)}."
    fields = {
        "name": name,
        "NAME": name.upper(),
        "version": __version__,
        "headline": to_plain(f"The dynamics of {model.name}"),
        "constraints": wrap_comment(constraints),
        "operations": list_lines("Operations and numbers on the stack:", operations),
        "helpers": helpers,
        "graphs": graphs,
        "functions": "\n\n".join(bodies),
    }
    lines = []
    for symbol, (key, variables) in zip("xupy", _group_variables(model).items(), strict=True):
        lines.append(list_lines(f"{symbol}:", _describe_variables(symbol, variables)))
        fields[key] = str(len(variables))
        fields[f"{key[:-1]}_names"] = quote_strings(x.name for x in variables) or '""'
    fields["variables"] = "\n".join(lines)
    fields["least_pivot"] = repr(model.least_pivot)
    fields |= {key: join_numbers(getattr(model, key)) for key in ("start", "u", "p")}
    targets = {".h": "dynamics.h", ".c": "dynamics.c", "_main.c": "dynamics_main.c"}
    return {name + end: read_template(file).substitute(fields) for end, file in targets.items()}


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


def _print_c(name: str, label: str, function: ca.Function) -> str:
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


# --- Rust ----------------------------------------------------------------------------------------

_LIBM_ARGUMENTS = {"pow": 2, "atan2": 2, "fmin": 2, "fmax": 2, "copysign": 2, "hypot": 2, "fmod": 2}


def build_rust_files(model: DynamicsModel) -> dict[str, str]:
    """Return `NAME.rs`, a crate without the standard library whose functions of libm are linked."""
    name = build_name(model)
    body = "\n\n".join(_print_rust(_densify(model, label)) for label in FUNCTIONS)
    described: list[str] = []
    for symbol, variables in zip("xupy", _group_variables(model).values(), strict=True):
        described += _describe_variables(symbol, variables)
    used = sorted(set(re.findall(r"libm::(\w+)\(", body)))
    lines = [
        f"//! The dynamics of {to_plain(model.name)}: x' = f(t, x, u, p), y = g(t, x, u, p), in SI.",
        "//!",
        f"//! Written by planter {__version__}; do not edit. Matrices are row by row.",
        *(f"//! {line}" for line in described),
        "#![no_std]",
        "#![allow(clippy::all, unused_variables, unused_parens, non_snake_case)]",
        "",
        *_list_rust_constants(model),
        "",
        "mod libm {",
        *(f"    {_print_rust_import(function)}" for function in used),
        '    extern "C" {' if used else "",
        *(f'        #[link_name = "{f}"] fn {f}_({_rust_arguments(f)}) -> f64;' for f in used),
        "    }" if used else "",
        "}",
        "",
        body,
    ]
    return {f"{name}.rs": "\n".join(lines) + "\n"}


def _rust_arguments(function: str) -> str:
    return ", ".join(f"{letter}: f64" for letter in "ab"[: _LIBM_ARGUMENTS.get(function, 1)])


def _print_rust_import(function: str) -> str:
    names = ", ".join("ab"[: _LIBM_ARGUMENTS.get(function, 1)])
    head = f"pub fn {function}({_rust_arguments(function)}) -> f64"
    return f"{head} {{ unsafe {{ {function}_({names}) }} }}"


def _list_rust_constants(model: DynamicsModel) -> list[str]:
    lines = []
    for key, variables in _group_variables(model).items():
        names = ", ".join(f'"{variable.name}"' for variable in variables)
        lines.append(f"pub const {key.upper()}: [&str; {len(variables)}] = [{names}];")
    for key in ("start", "u", "p"):
        values = getattr(model, key).tolist()
        lines.append(f"pub const {key.upper()}: [f64; {len(values)}] = {values!r};")
    return lines


def _print_rust(function: ca.Function) -> str:
    graph = LaneGraph.from_function(function, ())
    arguments = ["t: f64"]
    for index, name in enumerate(function.name_in()[1:], 1):
        arguments.append(f"{name}: &[f64; {function.numel_in(index)}]")
    for index, name in enumerate(function.name_out()):
        arguments.append(f"{name}: &mut [f64; {function.numel_out(index)}]")
    lines = [RUST.assign(x, x.arguments) for x in graph.assignments]
    lines += [f"    {s.place.name}[{s.place.index}] = {s.value};" for s in graph.stores]
    return "\n".join([f"pub fn {function.name()}({', '.join(arguments)}) {{", *lines, "}"])


# --- Python --------------------------------------------------------------------------------------

_HEAD = '''"""The dynamics of {title}: x' = f(t, x, u, p), y = g(t, x, u, p), in SI units and radians.

Written by planter {version}; do not edit. {about}
"""

{imports}

{constants}


'''
_JAX = """It needs JAX alone. `rates` returns x' and the least pivot of the
constraints over the largest, near 0 where they depend on each other; `outputs_at` returns y. They
take jax.jit, jax.vmap, jax.grad; double precision needs
jax.config.update("jax_enable_x64", True)."""
_CASADI = """It needs CasADi {casadi} or newer, and {file} beside it.

    functions = load()
    xdot, pivot = functions["f"](0, START, U, P)

Functions: f -> xdot, pivot; f_jacobian -> A, B, F; y -> y; y_jacobian -> C, D, G;
curvature(t, x, u, p, weights, direction) -> derivative along the direction of the gradient of
weights^T xdot by x, u, p.
Where pivot is near 0 the constraints that are kept, {constraints}, depend on each other."""
_LOADER = '''def load():
    """Return the CasADi functions by name."""
    text = Path(__file__).with_suffix(".casadi").read_text()
    file = casadi.StringDeserializer(text)
    functions = [file.unpack() for _ in {names}]
    return {{function.name(): function for function in functions}}
'''
_SAVED = (*FUNCTIONS.values(), "curvature")
"""Functions that CasADi's file has, in its order."""


def _begin_module(model: DynamicsModel, about: str, imports: str) -> str:
    """Return what Python modules begin with: names, units and meanings as lists of triples."""
    lines = []
    for key, variables in _group_variables(model).items():
        rows = "".join(f"    {(x.name, x.unit, x.meaning)!r},\n" for x in variables)
        lines.append(f"{key.upper()} = [\n{rows}]")
    numbers = {key.upper(): getattr(model, key).tolist() for key in ("start", "u", "p")}
    numbers["LOWER_U"] = [variable.low for variable in model.inputs]
    numbers["UPPER_U"] = [variable.high for variable in model.inputs]
    lines += [
        f"{key} = {values!r}".replace("inf", 'float("inf")') for key, values in numbers.items()
    ]
    title = to_plain(model.name).replace("\\", "/").replace('"', "'")
    return _HEAD.format(
        title=title,
        version=__version__,
        about=about,
        imports=imports,
        constants="\n".join(lines),
    )


def build_casadi_files(model: DynamicsModel) -> dict[str, str]:
    """Return `NAME.casadi`, the functions, and `NAME.py`, which loads them without planter."""
    name, saved = build_name(model), ca.StringSerializer()
    for function in _SAVED:
        saved.pack(getattr(model, function))
    about = _CASADI.format(
        casadi=ca.CasadiMeta.version(),
        file=f"{name}.casadi",
        constraints=", ".join(model.constraints) or "none",
    )
    module = _begin_module(model, about, "from pathlib import Path\n\nimport casadi")
    module += _LOADER.format(names=_SAVED)
    return {f"{name}.casadi": str(saved.encode()), f"{name}.py": module}


def build_jax_files(model: DynamicsModel) -> dict[str, str]:
    """Return `NAME.py`, a module that needs JAX alone."""
    functions = (_densify(model, label) for label in ("rates", "outputs_at"))
    texts = [HELPERS, *(JaxPrinter(function).print_function() for function in functions)]
    module = _begin_module(model, _JAX, IMPORTS)
    return {f"{build_name(model)}.py": module + "\n\n".join(texts)}


BUILDERS: Mapping[str, Callable[[DynamicsModel], dict[str, str]]] = {
    "casadi": build_casadi_files,
    "jax": build_jax_files,
    "rust": build_rust_files,
}
"""Functions that return the files of a language by name."""
