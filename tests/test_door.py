"""Files and texts of users come in by `planter.files.text`, results go out by
`planter.report.folder`; nothing else.
"""

import ast
import re
from collections.abc import Callable, Iterable, Iterator

import pytest

from tests.support.structure import ROOT

DOOR = "files/text.py"
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
"""Modules whose `load`, `loads` and `open` read: a method of that name of something else does
not.
"""
ALLOWED = {
    "audit/numbers.py": "printed numbers of installed rooms",
    "bench/tasks.py": "a drawing that the measured program wrote a moment before",
    "bench/mechanisms.py": "copies this program itself",
    "bench/measurement.py": "/proc/cpuinfo",
    "cli/commands.py": "references of installed packages, topics of this program",
    "clutch/report/shape.py": "an animation that was written a moment before",
    "report/folder.py": "the lock of a folder, opened without following links",
    "files/examples.py": "files that installed rooms bring",
    "interchange/co_simulation.py": (
        "files of this program, a library that was compiled a moment before"
    ),
    "kernels/builds.py": "/proc of processes that compile",
    "kernels/generated.py": "functions of installed rooms",
    "kernels/programs.py": "a program that was compiled a moment before",
    "kernels/toolchain.py": "compiled functions, opened without following links, /proc/cpuinfo",
    "mechanism/printed.py": "a table that this module wrote as text a moment before",
    "optimise/proof/certificate_file.py": "a document that this module built a moment before",
    "optimise/proof/check_proof.py": "the proof that it checks, as a program of its own",
    "parallel/jobs.py": "answers of processes that this one started",
    "parallel/task.py": "a task, and its jobs, of the process that started this one",
    "planting/family_pairs.py": "an entry that this module wrote a moment before",
    "planting/printed/attainable.py": "a front of this program",
    "terminal/process.py": "the null device",
    "view/animation.py": "an animation that was written a moment before",
    "studio/live.py": (
        "answers of a process that this one started, and what commands of this program printed"
    ),
    "studio/session.py": "requests of the process that started this one",
    "workers.py": "messages between a process and one that it started",
}
"""Modules that read something else than what a user hands in, and what."""


def readings(source: str) -> Iterator[tuple[int, str]]:
    """Lines of a source with a call that reads, or a name of one, but for files of this program by
    `resources`.
    """
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import | ast.ImportFrom):
            names = [alias.name for alias in node.names]
            module = node.module if isinstance(node, ast.ImportFrom) else None
            if "tomllib" in (module, *names) or (module in PARSERS and READERS & set(names)):
                yield node.lineno, f"import of {module or names[0]}"
        elif isinstance(node, ast.Attribute) and node.attr in READERS:
            if _is_a_reader(node) and not _is_packaged(node.value):
                yield node.lineno, node.attr
        elif (
            isinstance(node, ast.Call)
            and isinstance(node.func, ast.Name)
            and node.func.id == "open"
        ):
            yield node.lineno, "open"


def _is_a_reader(node: ast.Attribute) -> bool:
    if (
        node.attr == "open"
    ):  # of a module, or of a path: a machine that is opened is a Shown, a session or a kind
        return isinstance(node.value, ast.Name) and (
            node.value.id in PARSERS or "path" in node.value.id
        )
    if node.attr in ("load", "loads"):
        return isinstance(node.value, ast.Name) and node.value.id in PARSERS
    return not (isinstance(node.value, ast.Name) and node.value.id == "text")


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


def scan(
    find: Callable[[str], Iterator[tuple[int, str]]], words: Iterable[str]
) -> dict[str, list[tuple[int, str]]]:
    """Modules of `planter` in which something is found, with the places; those without the words
    are not parsed.
    """
    folder, word = ROOT / "planter", re.compile(rf"\b({'|'.join(sorted(words))})\b")
    sources = {
        path.relative_to(folder).as_posix(): path.read_text("utf-8")
        for path in sorted(folder.rglob("*.py"))
    }
    places_by_module = {
        name: list(find(source)) for name, source in sources.items() if word.search(source)
    }
    return {name: places for name, places in places_by_module.items() if places}


def test_only_the_door_reads_files_of_users() -> None:
    reading = scan(readings, {"tomllib", *READERS})
    assert not {name: places for name, places in reading.items() if name not in {*ALLOWED, DOOR}}
    assert not ALLOWED.keys() - reading.keys(), "exceptions that are not needed any more"


WAY_OUT = "report/folder.py"
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
    "kernels/builds.py": "folders of the cache",
    "kernels/programs.py": "a scratch folder",
    "kernels/toolchain.py": "a scratch folder",
    "interchange/co_simulation.py": "a scratch folder",
    "studio/session.py": "a scratch folder",
    "sweeps/job.py": "a database that --overwrite replaces",
}
"""Modules that write something else than a result, and what."""


def writings(source: str) -> Iterator[tuple[int, str]]:
    """Lines of a source that write or delete a file, but for those that do it by the functions of
    `planter.report`.
    """
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Attribute) and node.attr in WRITERS:
            holder = node.value.id if isinstance(node.value, ast.Name) else ""
            if node.attr in ("replace", "remove", "rename"):  # texts and lists have these, too
                if holder == "os":
                    yield node.lineno, node.attr
            elif holder not in ("files", "folder"):
                yield node.lineno, node.attr


def test_results_are_written_by_a_single_module() -> None:
    result = scan(writings, WRITERS)
    assert not {name: places for name, places in result.items() if name not in {*WRITING, WAY_OUT}}
    assert not WRITING.keys() - result.keys(), "exceptions that are not needed any more"


@pytest.mark.parametrize(
    "source",
    ["path.write_text(x)", "Path(out).write_bytes(x)", "shutil.rmtree(x)", "os.replace(a, b)"],
)
def test_other_writer_is_detected(source: str) -> None:
    assert list(writings(source))
    assert not list(writings("files.write_text(path, x)\ntext.replace(a, b)"))


@pytest.mark.parametrize(
    "source",
    [
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
    ],
)
def test_other_reader_is_detected(source: str) -> None:
    assert list(readings(source))


@pytest.mark.parametrize(
    "source",
    [
        "resources.files(__package__).joinpath('x').read_text()",
        "text.read_text(path)",
        "read_text(path)",
        "json.dumps(x)",
        "kind.open(source)",
        "load(path)",
    ],
)
def test_allowed_readers_read_no_user_files(source: str) -> None:
    assert not list(readings(source))
