"""The dynamics as C and as CasADi functions, called without planter."""

from __future__ import annotations

import ctypes
import importlib.util
import json
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from tempfile import mkdtemp
from time import process_time
from typing import Any

import numpy as np
import pytest

from planter.exports.dynamics import build_jax_files
from planter.exports.jax_module import IMPORTS
from planter.kernels import Array
from planter.mechanism.state_space.model import DynamicsModel, load_dynamics
from tests.planter.mechanism.state_space.statements import build_chain, build_tree
from tests.planter.mechanism.state_space.test_model import SOURCES, draw_states, find_path, model
from tests.support import own
from tests.support.cli import answer
from tests.support.lanes import STRICT, needs_compiler, path_of

MISSING, NOT_FINITE = 1, 2
SANITISED = ("-fsanitize=address,undefined", "-fno-sanitize-recover")


@cache
def write_c(name: str) -> Path:
    folder = Path(mkdtemp())
    files = answer("export", "c", str(find_path(name)), "--out", str(folder))["files"]
    assert {Path(file).suffix for file in files} == {".h", ".c"}
    return folder


def find_stem(name: str) -> str:
    return SOURCES[name][1]


class Library:
    """The C of a model, compiled as strictly as can be; `real` is a type of C."""

    def __init__(self, name: str, real: str, text: str | None = None) -> None:
        self.name, stem = name, find_stem(name)
        folder = Path(mkdtemp())
        shutil.copytree(write_c(name), folder, dirs_exist_ok=True)
        if text is not None:
            (folder / f"{stem}.c").write_text(text, encoding="utf-8")
        target = folder / "library.so"
        flags = ("-pedantic", f"-D{stem.upper()}_REAL={real}", "-fPIC", "-shared", "-O1")
        command = [path_of("gcc"), *STRICT, *flags, str(folder / f"{stem}.c"), "-lm", "-o"]
        subprocess.run([*command, str(target)], check=True, capture_output=True)
        self._library = ctypes.CDLL(str(target))
        self._stem = stem
        self._real = {"double": ctypes.c_double, "float": ctypes.c_float}[real]
        self._type = {"double": np.float64, "float": np.float32}[real]

    def call(self, function: str, arguments: tuple[Array | None, ...], *sizes: int) -> tuple:
        """Return the status and the results; an argument may be a null pointer."""
        results = [np.full(max(size, 1), np.nan, self._type) for size in sizes]
        passed = [None if part is None else np.array(part, self._type) for part in arguments]
        pointers = [None if part is None else part.ctypes.data for part in (*passed, *results)]
        call = getattr(self._library, f"{self._stem}_{function}")
        call.argtypes = [self._real, *len(pointers) * [ctypes.c_void_p]]
        status = call(0.0, *pointers)
        return status, *(part[:size] for part, size in zip(results, sizes, strict=True))


def list_sizes(subject: DynamicsModel) -> tuple[int, int, int, int]:
    variables = subject.states, subject.inputs, subject.parameters, subject.outputs
    return tuple(map(len, variables))


def find_error(library: Library, subject: DynamicsModel, state: Array) -> float:
    """The largest error of all functions, over the largest number of each."""
    arguments = state, subject.u, subject.p
    n, m, q, r = list_sizes(subject)
    expected = {
        "rates": (subject.rates(0.0, state), subject.pivot(0.0, state)),
        "rates_jacobian": subject.linearised(0.0, state),
        "outputs_at": (subject.outputs_at(0.0, state),),
        "outputs_jacobian": subject.linearised_outputs(0.0, state),
    }
    sizes = {
        "rates": (n, 1),
        "rates_jacobian": (n * n, n * m, n * q),
        "outputs_at": (r,),
        "outputs_jacobian": (r * n, r * m, r * q),
    }
    worst = 0.0
    for function, values in expected.items():
        status, *results = library.call(function, arguments, *sizes[function])
        assert status == 0
        for result, value in zip(results, values, strict=True):
            error = np.abs(result - np.ravel(value)).max(initial=0.0)
            worst = max(worst, error / max(1.0, np.abs(value).max(initial=0.0)))
    return worst


@needs_compiler
@pytest.mark.parametrize("real", ["double", "float"])
@pytest.mark.parametrize(
    "name", ["cart", "cranks", "rubbing", "row_unit", "odd", "four-bar", "platform"]
)
def test_c_returns_what_the_model_does(name: str, real: str) -> None:
    library, subject = Library(name, real), model(name)
    for state in draw_states(name, 2):
        assert find_error(library, subject, state) < {"double": 1e-13, "float": 2e-3}[real]


@needs_compiler
def test_changed_c_is_noticed() -> None:
    text = (write_c("cart") / "own.c").read_text(encoding="utf-8")
    assert "sin(" in text
    library = Library("cart", "double", text.replace("sin(", "tan(", 1))
    state = np.array([0.1, 0.7, 0.2, 1.3])
    assert find_error(library, model("cart"), state) > 1e-3


@needs_compiler
@pytest.mark.long
def test_c_of_a_long_chain_returns_what_the_model_does() -> None:
    """24 links: some 100,000 operations of Jacobians."""
    library, subject = Library("chain", "double"), model("chain")
    state = np.random.default_rng(3).normal(size=48)
    assert find_error(library, subject, state) < 1e-12


ABUSE = """
#include "own.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { N = OWN_STATES, M = OWN_INPUTS, Q = OWN_PARAMETERS, R = OWN_OUTPUTS };
static int failures = 0;

static own_real *copy(const own_real *values, int count)
{
  own_real *copied = malloc((size_t)count * sizeof *copied + (count == 0));
  if (values) memcpy(copied, values, (size_t)count * sizeof *copied);
  return copied;
}

static void expect(int status, int expected, int line)
{
  if (status != expected) printf("line %d: %d\\n", line, status), ++failures;
}
#define EXPECT(call, status) expect(call, status, __LINE__)
#define ALL(x, u, p, status) \\
  EXPECT(own_rates(0, x, u, p, f[0], f[1]), status); \\
  EXPECT(own_rates_jacobian(0, x, u, p, f[2], f[3], f[4]), status); \\
  EXPECT(own_outputs_at(0, x, u, p, f[5]), status); \\
  EXPECT(own_outputs_jacobian(0, x, u, p, f[6], f[7], f[8]), status);

int main(void)
{
  const int sizes[] = { N, 1, N * N, N * M, N * Q, R, R * N, R * M, R * Q };
  own_real *x = copy(own_start, N), *u = copy(own_u, M), *p = copy(own_p, Q), *f[9];
  int i;
  for (i = 0; i < 9; ++i) f[i] = copy(NULL, sizes[i]);
  ALL(x, u, p, OWN_OK)
  ALL(NULL, u, p, OWN_MISSING)
  ALL(x, NULL, p, M ? OWN_MISSING : OWN_OK)
  ALL(x, u, NULL, Q ? OWN_MISSING : OWN_OK)
  for (i = 0; i < N; ++i) x[i] = (own_real)NAN;
  EXPECT(own_rates_jacobian(0, x, u, p, f[2], f[3], f[4]), OWN_NOT_FINITE);
  for (i = 0; i < N; ++i) x[i] = (own_real)INFINITY;
  EXPECT(own_rates_jacobian(0, x, u, p, f[2], f[3], f[4]), OWN_NOT_FINITE);
  for (i = 0; i < 9; ++i) free(f[i]), f[i] = NULL;
  memcpy(x, own_start, N * sizeof *x);
  ALL(x, u, p, OWN_OK)
  free(x), free(u), free(p);
  return failures != 0;
}
"""
"""Calls with arrays of exactly their sizes, without some of them, and with no results."""


def run_abuse(name: str, real: str, folder: Path, text: str = ABUSE) -> int:
    """The exit status of `ABUSE` under the address sanitiser."""
    shutil.copytree(write_c(name), folder, dirs_exist_ok=True)
    (folder / "abuse.c").write_text(text, encoding="utf-8")
    sources = [str(folder / "own.c"), str(folder / "abuse.c")]
    flags = [*STRICT, "-pedantic", f"-DOWN_REAL={real}", *SANITISED, *sources, "-lm", "-o"]
    program = folder / "abuse"
    subprocess.run([path_of("gcc"), *flags, str(program)], check=True, capture_output=True)
    return subprocess.run([program], capture_output=True, check=False).returncode


@needs_compiler
@pytest.mark.parametrize("real", ["double", "float"])
@pytest.mark.parametrize("name", ["cart", "cranks", "four-bar", "platform"])
def test_bad_arguments_touch_no_foreign_memory(name: str, real: str, tmp_path: Path) -> None:
    assert run_abuse(name, real, tmp_path) == 0


@needs_compiler
def test_array_that_is_too_small_is_noticed(tmp_path: Path) -> None:
    assert run_abuse("cart", "double", tmp_path, ABUSE.replace("{ N, 1,", "{ N - 1, 1,")) != 0


def test_c_has_no_heap_and_tells_its_operations() -> None:
    subject, folder = model("platform"), write_c("platform")
    header, source = (folder / f"own{end}" for end in (".h", ".c"))
    assert not re.search(r"\b(malloc|calloc|realloc|free)\b", source.read_text(encoding="utf-8"))
    f = subject.f
    (line,) = re.findall(r"own_rates: (\d+), (\d+)", header.read_text(encoding="utf-8"))
    assert abs(int(line[0]) - f.n_instructions()) < 0.1 * f.n_instructions()
    assert 0 < int(line[1]) < int(line[0])


@needs_compiler
def test_c_says_what_is_missing_and_what_is_not_finite() -> None:
    library, subject = Library("cart", "double"), model("cart")
    state, u, p = subject.start, subject.u, subject.p
    for arguments in ((None, u, p), (state, None, p), (state, u, None)):
        assert library.call("rates", arguments, 4, 1)[0] == MISSING
    assert library.call("rates", (state + np.nan, u, p), 4, 1)[0] == NOT_FINITE
    assert library.call("rates", (state, u, 0 * p), 4, 1)[0] == NOT_FINITE


@needs_compiler
def test_program_moves_as_the_model_and_touches_no_foreign_memory(tmp_path: Path) -> None:
    folder = write_c("cranks")
    program = tmp_path / "program"
    sources = [str(folder / "own.c"), str(folder / "own_main.c")]
    command = [path_of("gcc"), *STRICT, "-pedantic", *SANITISED, *sources, "-lm", "-o"]
    subprocess.run([*command, str(program)], check=True, capture_output=True)
    done = subprocess.run([program, "0.2", "0.001"], check=True, capture_output=True, text=True)
    head, *_, last = done.stdout.strip().splitlines()
    dynamics = model("cranks").dynamics
    assert head.split(",") == ["t", *dynamics.names]
    motion = dynamics.run(np.array([0.0, 0.2]))
    np.testing.assert_allclose(
        [float(cell) for cell in last.split(",")[1:]], motion.states[:, -1], atol=1e-8
    )
    assert subprocess.run([program, "-1"], capture_output=True, check=False).returncode == 2


def test_casadi_functions_are_loaded_without_planter(tmp_path: Path) -> None:
    answer("export", "casadi", str(find_path("cart")), "--out", str(tmp_path))
    state = [0.1, 0.7, -0.3, 0.9]
    program = (
        "import json, sys, own\n"
        "functions = own.load()\n"
        f"arguments = 0, {state}, [3], own.P\n"
        "rates, pivot = functions['f'](*arguments)\n"
        "slopes = [part.full().tolist() for part in functions['f_jacobian'](*arguments)]\n"
        "assert not any(name.startswith('planter') for name in sys.modules)\n"
        "print(json.dumps([rates.full().ravel().tolist(), slopes, own.INPUTS, own.UPPER_U]))\n"
    )
    command = [sys.executable, "-c", program]
    done = subprocess.run(command, cwd=tmp_path, check=True, capture_output=True, text=True)
    rates, slopes, inputs, upper = json.loads(done.stdout)
    subject = model("cart")
    np.testing.assert_allclose(rates, subject.rates(0.0, np.array(state), np.array([3.0])))
    expected = subject.linearised(0.0, np.array(state), np.array([3.0]))
    for slope, reference in zip(slopes, expected, strict=True):
        np.testing.assert_allclose(slope, reference, atol=1e-14)
    assert (inputs, upper) == ([["F", "N", "force on the cart"]], [12.0])


RUST_MAIN = """
extern crate own;
fn main() {
    let state = [STATE];
    let (mut xdot, mut pivot, mut y) = ([0.0; N], [0.0; 1], [0.0; R]);
    let (mut a, mut b, mut f) = ([0.0; NN], [0.0; NM], [0.0; NQ]);
    own::rates(0.0, &state, &own::U, &own::P, &mut xdot, &mut pivot);
    own::outputs_at(0.0, &state, &own::U, &own::P, &mut y);
    own::rates_jacobian(0.0, &state, &own::U, &own::P, &mut a, &mut b, &mut f);
    println!("[{:?}, {:?}, {:?}, {:?}, {:?}]", xdot, y, a, b, f);
}
"""


@pytest.mark.parametrize("name", ["cart", "cranks", "rubbing", "odd"])
def test_rust_without_its_library_returns_what_the_model_does(tmp_path: Path, name: str) -> None:
    compiler = shutil.which("rustc")
    if compiler is None:
        pytest.skip("no Rust compiler")
    answer("export", "rust", str(find_path(name)), "--out", str(tmp_path))
    subject, state = model(name), draw_states(name, 1)[0]
    n, m, q, r = list_sizes(subject)
    words = {"NN": n * n, "NM": n * m, "NQ": n * q, "N": n, "R": r}
    text = RUST_MAIN.replace("STATE", ", ".join(map(repr, state.tolist())))
    for word, size in words.items():
        text = text.replace(f"; {word}]", f"; {size}]")
    (tmp_path / "main.rs").write_text(text, encoding="utf-8")
    for flags in (["--crate-type", "rlib", "own.rs"], ["-L", ".", "main.rs"]):
        subprocess.run([compiler, "--edition", "2021", *flags], cwd=tmp_path, check=True)
    done = subprocess.run([tmp_path / "main"], check=True, capture_output=True, text=True)
    expected = [subject.rates(0.0, state), subject.outputs_at(0.0, state)]
    expected += subject.linearised(0.0, state)
    for result, value in zip(json.loads(done.stdout), expected, strict=True):
        size = max(1.0, np.abs(value).max(initial=0.0))
        np.testing.assert_allclose(result, np.ravel(value), atol=1e-13 * size)


@pytest.mark.parametrize("name", ["cart", "cranks", "rubbing", "row_unit", "odd"])
def test_jax_returns_what_the_model_does(tmp_path: Path, name: str) -> None:
    jax = pytest.importorskip("jax")
    jax.config.update("jax_enable_x64", True)
    (file,) = answer("export", "jax", str(find_path(name)), "--out", str(tmp_path))["files"]
    spec = importlib.util.spec_from_file_location("exported", file)
    assert spec is not None
    assert spec.loader is not None
    exported = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(exported)
    subject, states = model(name), np.array(draw_states(name, 3))
    u, p = np.array(exported.U), np.array(exported.P)
    rates = jax.jit(jax.vmap(lambda state: exported.rates(0.0, state, u, p)[0]))(states)
    expected = [subject.rates(0.0, state) for state in states]
    np.testing.assert_allclose(rates, expected, rtol=1e-10, atol=1e-10)
    expected = subject.linearised(0.0, states[0])[0]
    for differentiate in (jax.jacfwd, jax.jacrev):
        slope = differentiate(lambda state: exported.rates(0.0, state, u, p)[0])(states[0])
        np.testing.assert_allclose(slope, expected, rtol=1e-9, atol=1e-8)
    outputs = exported.outputs_at(0.0, states[0], u, p)
    np.testing.assert_allclose(outputs, subject.outputs_at(0.0, states[0]), rtol=1e-10, atol=1e-10)


class Scan:
    """Loops of JAX, in Python: the carried values, then the rows of the results."""

    stop_gradient = staticmethod(np.asarray)

    @staticmethod
    def scan(step: Callable, carried: tuple, rows: tuple | None, count: int) -> tuple:
        results = []
        for turn in range(count):
            row = None if rows is None else tuple(part[turn] for part in rows)
            carried, result = step(carried, row)
            results.append(result)
        return carried, tuple(np.array(part) for part in zip(*results, strict=True))


def run_jax_text(subject: DynamicsModel, change: tuple[str, str] = ("", "")) -> dict[str, Any]:
    """What a module for JAX defines, with NumPy for JAX: its arithmetic is the same."""
    (text,) = build_jax_files(subject).values()
    assert change[0] in text
    names: dict[str, Any] = {"jnp": np, "lax": Scan}
    exec(text.replace(IMPORTS, "").replace(*change, 1), names)
    return names


CHAIN = 12
LOOPED = ("cart", "cranks", "rubbing", "whipple", "row_unit", "chain")


@cache
def chain(links: int = CHAIN) -> DynamicsModel:
    return load_dynamics(own.generated(build_chain(links)) / "own.toml")


def find_jax_error(subject: DynamicsModel, module: dict[str, Any]) -> float:
    rng, worst = np.random.default_rng(6), 0.0
    for _ in range(3):
        state = subject.start + 0.3 * rng.standard_normal(len(subject.start))
        for values, expected in (
            (module["rates"](0.0, state, subject.u, subject.p)[0], subject.rates(0.0, state)),
            (
                module["outputs_at"](0.0, state, subject.u, subject.p),
                subject.outputs_at(0.0, state),
            ),
        ):
            worst = max(worst, np.abs(values - expected).max() / np.abs(expected).max())
    return worst


@pytest.mark.parametrize("name", LOOPED)
def test_loops_of_equal_bodies_compute_what_the_model_does(name: str) -> None:
    subject = chain() if name == "chain" else model(name)
    assert find_jax_error(subject, run_jax_text(subject)) < 1e-11


def test_another_order_of_a_loop_is_noticed() -> None:
    module = run_jax_text(chain(), ("::-1]", f"][:{CHAIN}]"))
    with pytest.raises(IndexError):
        find_jax_error(chain(), module)
    module = run_jax_text(chain(), (f"        x[2:{CHAIN}]", f"        x[1:{CHAIN - 1}]"))
    assert find_jax_error(chain(), module) > 1e-3


def test_text_of_equal_bodies_does_not_grow_with_their_number() -> None:
    sizes = []
    for links in (12, 24):
        (text,) = build_jax_files(chain(links)).values()
        sizes.append(len(text.partition("def rates(")[2].partition("\ndef ")[0].splitlines()))
    assert sizes[1] < 1.05 * sizes[0]


def test_jax_compiles_thirty_bodies_in_seconds(tmp_path: Path) -> None:
    """With their gradient and a batch, and against Pinocchio."""
    jax = pytest.importorskip("jax")
    pin = pytest.importorskip("pinocchio")
    jax.config.update("jax_enable_x64", True)
    links = 30
    (text,) = build_jax_files(chain(links)).values()
    names: dict[str, Any] = {}
    exec(text, names)
    states = np.random.default_rng(1).normal(size=(5, 2 * links))

    def measure(state: Array) -> Array:
        return names["rates"](0.0, state, names["U"], names["P"])[0]

    begin = process_time()
    rates = jax.jit(jax.vmap(measure))(states)
    slope = jax.jit(jax.grad(lambda state: measure(state) @ np.ones(2 * links)))(states[0])
    assert process_time() - begin < 20
    tree = build_tree(links)
    data = tree.createData()
    expected = [pin.aba(tree, data, s[:links], s[links:], np.zeros(links)) for s in states]
    size = np.abs(expected).max()
    np.testing.assert_allclose(rates[:, links:], expected, atol=1e-12 * size)
    gradient = chain(links).linearised(0.0, states[0])[0].sum(axis=0)
    np.testing.assert_allclose(slope, gradient, atol=1e-10 * np.abs(gradient).max())
