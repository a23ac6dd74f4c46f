"""Rules over the syntax of the sources, each with modules that may break it, and why.

Files and texts of users come in by `planter.text_files`, results go out by `planter.report.folder`;
mechanics is derived, not typed; no determinant or linear system is solved by expansion.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import pytest

from derive.emit.targets import array, casadi
from planter.kernels import generated
from tests.support.structure import ROOT

READERS = {
    "read_text",
    "read_bytes",
    "load",
    "loads",
    "open",
    "fdopen",
    "receive_json",
    "loadtxt",
    "genfromtxt",
    "fromfile",
    "memmap",
    "read_csv",
    "read_parquet",
    "readfile",
    "file_digest",
    "copytree",
    "copyfile",
    "copy2",
}
"""Functions and methods that read a file or parse a text."""
PARSERS = {"tomllib", "json", "np", "numpy", "pickle", "yaml", "pandas", "io", "os", "shutil"}
"""Modules whose `load`, `loads` and `open` read: a method of that name of something else does not."""
READING = {
    "text_files.py": "the door",
    "audit/numbers.py": "printed numbers of installed rooms",
    "cli/benchmark.py": "copies this program itself",
    "cli/guide.py": "topics of this program",
    "cli/references.py": "references of installed packages",
    "report/folder.py": "the lock of a folder, opened without following links",
    "files/documents.py": "pages and examples of this program",
    "files/examples.py": "files that installed rooms bring",
    "exports/fmi.py": ("files of this program, a library that was compiled a moment before"),
    "kernels/builds.py": "/proc of processes that compile",
    "kernels/generated.py": "functions of installed rooms",
    "kernels/programs.py": "a program that was compiled a moment before",
    "kernels/toolchain.py": "compiled functions, opened without following links, /proc/cpuinfo",
    "mechanism/printed.py": "a table that this module wrote as text a moment before",
    "engine/proof/certificate_file.py": "a document that this module built a moment before",
    "engine/proof/check_proof.py": "the proof that it checks, as a program of its own",
    "jobs.py": "answers of processes that this one started",
    "task.py": "a task, and its jobs, of the process that started this one",
    "papers/planting/family_pairs.py": "an entry that this module wrote a moment before",
    "papers/planting/calibration.py": "the record of a study of this program",
    "report/process.py": "the null device",
    "report/animation.py": "an animation that was written a moment before",
    "studio/live.py": (
        "answers of a process that this one started, and what commands of this program printed"
    ),
    "studio/session.py": "requests of the process that started this one",
    "workers.py": "messages between a process and one that it started",
}
"""Modules that read something, and what."""


def find_readings(tree: ast.AST) -> Iterator[str]:
    """Lines of a source with a call that reads, or a name of one, but for files of this program by
    `resources`.
    """
    for node in ast.walk(tree):
        if isinstance(node, ast.Import | ast.ImportFrom):
            names = [alias.name for alias in node.names]
            module = node.module if isinstance(node, ast.ImportFrom) else None
            if "tomllib" in (module, *names) or (module in PARSERS and READERS & set(names)):
                yield f"import of {module or names[0]}"
        elif isinstance(node, ast.Attribute) and node.attr in READERS:
            if _is_a_reader(node) and not _is_packaged(node.value):
                yield node.attr
        elif (
            isinstance(node, ast.Call)
            and isinstance(node.func, ast.Name)
            and node.func.id == "open"
        ):
            yield "open"


def _is_a_reader(node: ast.Attribute) -> bool:
    if (
        node.attr == "open"
    ):  # of a module, or of a path: a machine that is opened is a Shown, a session or a kind
        return isinstance(node.value, ast.Name) and (
            node.value.id in PARSERS or "path" in node.value.id
        )
    if node.attr in ("load", "loads"):
        return isinstance(node.value, ast.Name) and node.value.id in PARSERS
    return not (isinstance(node.value, ast.Name) and node.value.id == "text_files")


def _is_packaged(node: ast.expr) -> bool:
    """Whether an expression is a chain of calls that starts with `files(...)` of
    importlib.resources.
    """
    while isinstance(node, ast.Call | ast.Attribute):
        if isinstance(node, ast.Call):
            callee = node.func
            if "files" in (getattr(callee, "id", ""), getattr(callee, "attr", "")):
                return True
        node = node.func if isinstance(node, ast.Call) else node.value
    return False


WRITERS = {
    "write_text",
    "write_bytes",
    "unlink",
    "rmtree",
    "replace",
    "rename",
    "remove",
    "rmdir",
    "savez",
    "savetxt",
}
"""Functions and methods that write or delete a file."""
WRITING = {
    "report/folder.py": "the way out",
    "kernels/builds.py": "folders of the cache",
    "kernels/programs.py": "a scratch folder",
    "kernels/toolchain.py": "a scratch folder",
    "exports/fmi.py": "a scratch folder",
    "studio/session.py": "a scratch folder",
    "rows/job.py": "a database that --overwrite replaces",
}
"""Modules that write something, and what."""


def find_writings(tree: ast.AST) -> Iterator[str]:
    """Lines of a source that write or delete a file, but for those that do it by the functions of
    `planter.report`.
    """
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and node.attr in WRITERS:
            holder = node.value.id if isinstance(node.value, ast.Name) else ""
            if node.attr in ("replace", "remove", "rename"):  # texts and lists have these, too
                if holder == "os":
                    yield node.attr
            elif holder not in ("files", "folder"):
                yield node.attr


ANGLES = {
    "cos",
    "sin",
    "tan",
    "acos",
    "asin",
    "atan",
    "atan2",
    "arccos",
    "arcsin",
    "arctan",
    "arctan2",
}
"""Functions that turn angles into components and back."""
DRAWN = {"report", "scene", "figures", "printed"}
"""Folders and modules of figures and scenes, which draw, and of what papers print."""
BY_HAND = {
    "papers/clutch/model.py": "direction of a line through two generated points",
    "papers/clutch/machines.py": (
        "lift of the link along the crank's angle, compared with the generated model in its test"
    ),
    "papers/clutch/rotor.py": (
        "normals of a polygon's sides in a linear programme; the outline that is drawn"
    ),
    "gears/geometry/pieces.py": "points and directions on circles",
    "gears/geometry/pitch_curves.py": "how steep a curve of a table is, to refuse it",
    "papers/mapping/dyads.py": "poses as points of a linear system, directions to search in",
    "papers/mapping/linkage.py": "roots of the generated closed loop, intervals between them",
    "papers/mapping/machines.py": (
        "the closed-form loop of a linkage, compared with the synthesis in its test"
    ),
    "papers/mapping/model.py": "angle of a generated vector",
    "papers/pickup/file.py": "whether a law that a user hands in goes forward",
    "papers/pickup/inverse.py": "directions of given points",
    "papers/pickup/law.py": "a law of motion that a user chooses, between its joints",
    "papers/planting/proof.py": "sines of enclosures, of the series that is generated",
    "papers/planting/toothed.py": "directions of generated points",
    "papers/planting/labelled.py": "directions and arcs of a drawing",
    "papers/planting/lifted.py": (
        "how far from the pitch point teeth are let touch, an input of the lifted model"
    ),
    "papers/planting/browser_programs.py": (
        "points of a generated outline as the planet holds them, for a drawing"
    ),
}
"""Modules of machines that call them, and what for; forces, contacts and rotations of gears are not
among it.
"""


def find_angle_functions(tree: ast.AST) -> Iterator[str]:
    """Functions of angles that a source calls, whatever library they are of."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Call):
            name = (
                node.func.attr
                if isinstance(node.func, ast.Attribute)
                else getattr(node.func, "id", "")
            )
            if name in ANGLES:
                yield name


GRAPHS = {
    "det",
    "solve",
    "inv",
    "inv_minor",
    "adj",
    "minor",
    "cofactor",
    "pinv",
    "mldivide",
    "mrdivide",
    "qr",
}
"""Functions of CasADi that expand minors of a graph, or solve by Gram-Schmidt without pivots."""
SYMBOLS = {"det", "inv", "LUsolve", "cramer_solve", "adjugate", "cofactor", "minor"}
"""Methods of SymPy's matrices whose results grow without bounds."""
SOLVERS_OF_NUMBERS = ("np.linalg", "scipy.linalg")
EXPANDING = {
    "derive/papers/clutch/geometry.py": "a conic, 3 x 3",
    "derive/papers/clutch/rotor.py": "two vectors in a plane",
    "derive/audit/user_mechanism/subject.py": "two simultaneous equations at most",
    "derive/mechanics/free_motion.py": "accelerations in symbols, which somebody asks for",
    "planter/engine/proof/check_proof.py": "numbers with error bounds",
}
"""Modules with small matrices of symbols, or of numbers."""


def find_expansions(tree: ast.AST) -> Iterator[str]:
    """Calls of such functions and methods, and imports of them, as text."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module == "casadi":
            yield from (alias.name for alias in node.names if alias.name in GRAPHS)
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
            receiver = ast.unparse(node.func.value)
            forbidden = GRAPHS if receiver in ("ca", "casadi") else SYMBOLS
            if node.func.attr in forbidden and receiver not in SOLVERS_OF_NUMBERS:
                yield ast.unparse(node.func)


def find_settings(tree: ast.AST) -> Iterator[str]:
    """What a module sets of another one when it is imported, as text: the precision of a library,
    which then holds for all that the process does.
    """
    waiting = list(ast.iter_child_nodes(tree))
    for node in waiting:
        if isinstance(node, ast.FunctionDef | ast.ClassDef | ast.Lambda):
            continue
        waiting += ast.iter_child_nodes(node)
        if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
            yield ast.unparse(node)


def list_machine_modules() -> Iterator[Path]:
    """Yield modules of machines and of gears, without those that draw or hold what papers print."""
    folder = ROOT / "planter"
    for room in ("papers", "gears/geometry"):
        for path in sorted((folder / room).rglob("*.py")):
            if not DRAWN & set(path.relative_to(folder).with_suffix("").parts):
                yield path


def list_modules(*packages: str) -> list[Path]:
    return [path for package in packages for path in sorted((ROOT / package).rglob("*.py"))]


@dataclass(frozen=True)
class _Rule:
    """What may stand in some modules alone, with sources that break the rule, and that do not.

    Modules are named by their path below `folder`.
    """

    find: Callable[[ast.AST], Iterator[str]]
    allowed: Mapping[str, str]
    modules: Callable[[], list[Path] | Iterator[Path]]
    bad: tuple[str, ...]
    good: tuple[str, ...]
    folder: str = "planter"


RULES = {
    "readers": _Rule(
        find_readings,
        READING,
        lambda: list_modules("planter"),
        (
            "import tomllib",
            "from tomllib import loads",
            "from json import loads",
            "json.loads(text)",
            "json.load(file)",
            "path.read_text()",
            "Path(source).read_bytes()",
            "open(path)",
            "path.open()",
            "np.loadtxt(path)",
            "os.open(path, 0)",
            "await socket.receive_json()",
            "Path(files(source)).with_name(name); there.read_text()",
            "read = Path.read_text",
        ),
        (
            "resources.files(__package__).joinpath('x').read_text()",
            "text_files.read_text(path)",
            "read_text(path)",
            "json.dumps(x)",
            "kind.open(source)",
            "load(path)",
        ),
    ),
    "writers": _Rule(
        find_writings,
        WRITING,
        lambda: list_modules("planter"),
        ("path.write_text(x)", "Path(o).write_bytes(x)", "shutil.rmtree(x)", "os.replace(a, b)"),
        ("files.write_text(path, x)\ntext.replace(a, b)",),
    ),
    "angles by hand": _Rule(
        find_angle_functions,
        BY_HAND,
        list_machine_modules,
        ("ca.cos(x)", "math.atan2(y, x)", "from numpy import sin\nsin(1)"),
        ('found["cos"]\n"sin(x)"\ncosine(2)\n',),
    ),
    "expansions": _Rule(
        find_expansions,
        EXPANDING,
        lambda: list_modules("planter", "derive", "generated"),
        (
            "ca.det(jacobian)",
            "-ca.solve(a, b)",
            "from casadi import det",
            "casadi.inv(m)",
            "matrix.det()",
        ),
        (
            "np.linalg.solve(a, b)",
            "recorder.solve(x)",
            "solve_system(a, b).solution",
            array.SOLVER,
            casadi.SOLVER,
        ),
        folder="",
    ),
    "settings on import": _Rule(
        find_settings,
        {"tests/conftest.py": "no compiled files of the suite's own"},
        lambda: list_modules("planter", "derive", "generated", "tests", "docs"),
        ("ctx.prec = 400", "try:\n    ctx.prec = 64\nexcept ImportError:\n    pass", "a.b += 1"),
        ("with ctx.workprec(80):\n    x = 1", "def main():\n    ctx.prec = 64", "x[0] = a.b"),
        folder="",
    ),
}


@pytest.mark.parametrize("rule", RULES.values(), ids=RULES)
def test_rule_is_broken_where_it_may_be(rule: _Rule) -> None:
    """Exceptions that are not needed any more go."""
    breaking = {
        path.relative_to(ROOT / rule.folder).as_posix()
        for path in rule.modules()
        if any(rule.find(ast.parse(path.read_text(encoding="utf-8"))))
    }
    assert breaking == rule.allowed.keys()


@pytest.mark.parametrize(
    ("rule", "source"), [(rule, source) for rule in RULES.values() for source in rule.bad]
)
def test_broken_rule_is_noticed(rule: _Rule, source: str) -> None:
    assert any(rule.find(ast.parse(source)))


@pytest.mark.parametrize(
    ("rule", "source"), [(rule, source) for rule in RULES.values() for source in rule.good]
)
def test_sound_source_breaks_no_rule(rule: _Rule, source: str) -> None:
    assert not any(rule.find(ast.parse(source)))


@pytest.mark.parametrize("constant", ["9.81", "9.80665"])
def test_weight_is_not_typed(constant: str) -> None:
    assert not [path for path in list_machine_modules() if constant in path.read_text("utf-8")]


def test_every_generated_model_is_used() -> None:
    """Of a machine or of the gears; what nobody calls would be derived for nothing."""
    text = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "planter").rglob("*.py"))
    complete = {
        name
        for name in generated.names()
        if f'"{name}"' not in text and not name.startswith("curve_")
    }
    composed = {name for name in complete if 'f"' + name.rpartition("_")[0] + "_{" in text}
    composed |= {name for name in complete if f'"{name.partition("_")[0]}_"' in text}
    assert complete - composed - {"audit", "audit_mathml", "verdicts"} == set()
