"""The session of a page: it answers messages about the machine that is open, which is its only
state.
"""

from __future__ import annotations

import json
import math
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

from planter import plugins, safe_text, workers
from planter.errors import InputError, PlanterError
from planter.files import examples
from planter.files.derivation import GENERATED
from planter.report import files
from planter.report.animation import pack_curves, pack_scene
from planter.report.folder import CLOSEST_FILE
from planter.report.picture import draw_picture
from planter.report.scene import Scene
from planter.report.subject import (
    ANIMATION,
    GOALS,
    MOST_STARTS,
    STEPS,
    AskingSearch,
    Export,
    GoalQuantity,
    LockingSearch,
    Refining,
    Searching,
    Shown,
    Values,
    Wishing,
    find_farthest,
    open_machine,
    refine_readings,
)
from planter.studio.process import describe_error, export_path, to_page_words
from planter.text_files import parse_toml, read_text

LARGEST = 1_000_000
"""Maximum characters of a loaded file."""
CODE, CODE_FOLDER = "functions", "folder"
"""Keys of a file that name its Python code, and the folder of that."""
ENDS_S = 4.0
"""Maximum time for the ranges of all numbers [s], estimated from the first one."""
OPENED = "opened.toml"
"""Default name of a loaded file."""
Message = Mapping[str, Any]


def list_sources(folder: Path) -> list[str]:
    """Return the machines that can be opened by name: files of the folder, then built-in ones."""
    return [
        *sorted(path.name for path in folder.glob("*.toml")),
        *examples.list_examples(None, ".toml"),
    ]


@dataclass(frozen=True)
class PreparedMachine:
    """A machine that was opened in advance, and the text of its file, None of a built-in one."""

    source: str
    text: str | None
    machine: Shown

    def fits(self, source: str) -> bool:
        """Return whether it is the machine of a source, whose file is as it was."""
        return source == self.source and _read_if_file(source) == self.text


def _read_if_file(source: str) -> str | None:
    return read_text(source) if Path(source).is_file() else None


class Session:
    """A page's session with the studio of a `folder`, whose machines are opened by name.

    Files that a page loads are stored in `scratch`. `explicit` is the file that the user named on
    the command line: its code may be in any folder.
    """

    def __init__(self, folder: Path, scratch: Path, explicit: Path | None = None) -> None:
        self.folder, self.scratch = folder.resolve(), scratch
        self._explicit = explicit and explicit.resolve()
        self.machine: Shown | None = None
        self._prepared: PreparedMachine | None = None
        self._texts = self._searches = 0
        self._labels: dict[str, str] = {}
        self._names: dict[str, str] = {}

    def in_page_words(self, error: PlanterError) -> str:
        """Return the message of an error with files and numbers named as on the page."""
        return to_page_words(error.message, self._labels | self._names)

    def open(self, message: Message) -> dict[str, Any]:
        """Open a machine by name or by the text of its file, and return its description for the
        page.
        """
        source = self._source(message)
        prepared = self._prepared if self._prepared and self._prepared.fits(source) else None
        self.machine = prepared.machine if prepared else open_machine(source)
        self._prepared = None
        self._names = {control.path: control.name for control in self.machine.controls}
        return {"opened": self._description()}

    def prepare(self, name: str) -> None:
        """Open a machine and draw it in advance of the page that asks for it."""
        source = self._source({"name": name})
        prepared = PreparedMachine(source, _read_if_file(source), open_machine(source))
        self._prepared, self.machine = prepared, prepared.machine
        self.seen({})

    def _description(self) -> dict[str, Any]:
        assert self.machine is not None
        return {
            "name": self.machine.name,
            "models": list(self.machine.models),
            "handles": [list(pair) for pair in self.machine.handles],
            "search": "Find a better design"
            if isinstance(self.machine, Searching) and self.machine.search
            else None,
            "lockable": self._lockable,
            "controls": [control.to_json() for control in self.machine.controls],
            "wishes": isinstance(self.machine, Wishing) and self.machine.wishes,
            "exports": [asdict(export) for export in self._exports],
        }

    def seen(self, message: Message) -> dict[str, Any]:
        """Return scenes and readings of the machine with changed numbers."""
        values, model = self._values_and_model(message)
        return {
            "scenes": _draw_scenes(self._open.scenes(values, model)),
            "readings": [asdict(reading) for reading in self._open.readings(values, model)],
            "refined": not isinstance(self._open, Refining),
        }

    def refine_first(self, message: Message) -> dict[str, Any]:
        """Return those readings by true extremes that are computed at once, or nothing if those of
        `seen` were true ones.
        """
        return self._refine(message, quickly=True)

    def refine(self, message: Message) -> dict[str, Any]:
        """Return all readings by true extremes, or nothing if those of `seen` were true ones."""
        return self._refine(message, quickly=False)

    def _refine(self, message: Message, quickly: bool) -> dict[str, Any]:
        if not isinstance(self._open, Refining):
            return {}
        readings = self._open.refined(*self._values_and_model(message), quickly)
        return {"readings": [asdict(reading) for reading in readings], "refined": not quickly}

    def _list_refined(self, values: Values, model: str) -> list[dict[str, Any]]:
        return [asdict(reading) for reading in refine_readings(self._open, values, model)]

    def design(self, message: Message) -> dict[str, Any]:
        """Return all that a page displays of the machine with changed numbers beside another
        design.
        """
        values, model = self._values_and_model(message)
        return {
            "design": {
                "scene": _draw_scenes(self._open.scenes(values, model)[:1])[0],
                "readings": self._list_refined(values, model),
                **self.checked(message),
                "values": values,
                "model": model,
            }
        }

    def finished(self, message: Message) -> dict[str, Any]:
        """Return the scenes with slow details, or nothing if they have none."""
        scenes = self._open.scenes(*self._values_and_model(message))
        if not any(scene.later for scene in scenes):
            return {}
        return {"finished": _draw_scenes([scene.with_details() for scene in scenes])}

    def checked(self, message: Message) -> dict[str, Any]:
        """Return the requirements of the machine with changed numbers."""
        return {
            "checks": [
                asdict(check) for check in self._open.checks(*self._values_and_model(message))
            ]
        }

    def details(self, message: Message) -> dict[str, Any]:
        """Return the tables for sizing of the machine with changed numbers, and the results of its
        other models.
        """
        values, model = self._values_and_model(message)
        other_models = [name for name in self._open.models if name != model]
        return {
            "details": [asdict(table) for table in self._open.details(values, model)],
            "beside": [{"model": name, **self._compare(values, name)} for name in other_models],
        }

    def ends(self, message: Message) -> dict[str, Any]:
        """Return the range of each number for the present values of the others, or nothing if that
        takes too long.
        """
        values, model = self._values_and_model(message)

        def attempt(path: str, number: float) -> None:
            self._open.readings({**values, path: number}, model)

        first = self._open.controls[0]
        self._open.readings(values, model)  # excludes the time of what is computed only once
        begun = time.process_time()
        attempt(first.path, values[first.path] + (first.upper - values[first.path]) / STEPS)
        if 2 * len(values) * (time.process_time() - begun) > ENDS_S:
            return {}
        ends = {}
        for control in self._open.controls:
            value, try_number = values[control.path], partial(attempt, control.path)
            ends[control.path] = [
                find_farthest(value, end, try_number) for end in (control.lower, control.upper)
            ]
        return {"ends": ends}

    def _compare(self, values: Values, model: str) -> dict[str, Any]:
        readings = self._list_refined(values, model)
        return {"readings": readings, "course": pack_curves(self._open.scenes(values, model)[0])}

    def file(self, message: Message) -> dict[str, Any]:
        """Return the machine's file with changed numbers."""
        return {"file": self._open.text(self._values_and_model(message)[0])}

    def wished(self, message: Message) -> dict[str, Any]:
        """Return the file with points of the tip path that a user can drag.

        Raises InputError if the machine cannot have such points.
        """
        if not isinstance(self._open, Wishing) or not self._open.wishes:
            raise InputError(f"{self._open.name} has no path that can be edited by points")
        return {"wished": self._open.wished(self._values_and_model(message)[0])}

    def plan(self, message: Message) -> dict[str, Any]:
        """Return what a page asks before a search: the stated goal, the quantities that another
        goal can be about, and the number of starts.

        Raises InputError if the machine cannot be optimised.
        """
        machine = self._searching
        return {
            "plan": {
                "goal": machine.describe_goal(),
                "quantities": [asdict(quantity) for quantity in self._goal_quantities(message)],
                "aims": list(GOALS),
                "starts": machine.starts,
            }
        }

    def search(self, message: Message) -> dict[str, Any]:
        """Return the command that optimises the machine's file, which is stored in the scratch
        folder, the folder of its results, and its goal.

        Raises InputError if the machine cannot be optimised, or for another goal or number of
        starts than `plan` offers.
        """
        machine, model = self._searching, self._values_and_model(message)[1]
        sum_text, starts = self._read_sum(message), message.get("starts", machine.starts)
        if (
            isinstance(starts, bool)
            or not isinstance(starts, int)
            or not 1 <= starts <= MOST_STARTS
        ):
            raise InputError(
                f"Starts = {safe_text.format_value(starts)}: a whole number from 1 to "
                f"{MOST_STARTS} is required"
            )
        self._searches += 1
        folder = f"search{self._searches}"
        path = self._store(folder, "machine.toml", self._search_text(message))
        out = path.with_name("out")
        options = ["--model", model] if len(self._open.models) > 1 else []
        options += ["--starts", str(starts)] if machine.starts > 1 else []
        options += [f"--least={sum_text}"] if sum_text else []
        closest = {str(out / CLOSEST_FILE): "B"}
        keys = {path.rpartition(".")[2]: self._names[path] for path in self._lockable}
        return {
            "command": [*machine.search, str(path), *options, "--json", "--out", str(out)],
            "out": str(out),
            "labels": {
                str(path): self._open.name,
                **closest,
                **keys,
                **self._names,
                **machine.words,
            },
            "goal": self._describe_goal(machine, sum_text),
            "starts": starts if machine.starts > 1 else 1,
        }

    def _read_sum(self, message: Message) -> str:
        """Return the sum of measures that a page has asked for, empty for the goal of the file.

        Raises InputError if there is none of both, or if the page offers no such goal.
        """
        machine, goal = self._searching, _table(message, "goal")
        if not goal and machine.describe_goal():
            return ""
        names = [quantity.name for quantity in self._goal_quantities(message)]
        name, template = goal.get("quantity"), GOALS.get(str(goal.get("aim")))
        if template is None or name not in names:
            raise InputError("choose a quantity, and what a search is to do with it")
        return template.format(name)

    def _goal_quantities(self, message: Message) -> Sequence[GoalQuantity]:
        machine, values = self._open, self._values_and_model(message)[0]
        return machine.list_goal_quantities(values) if isinstance(machine, AskingSearch) else ()

    def _describe_goal(self, machine: Searching, sum_text: str) -> str:
        if not sum_text:
            return machine.describe_goal()
        assert isinstance(machine, AskingSearch)
        return machine.describe_sum(sum_text)

    def _search_text(self, message: Message) -> str:
        """Return the file for a search, in which locked numbers have no room."""
        values, locked = self._values_and_model(message)[0], message.get("locked") or []
        if not locked:
            return self._open.text(values)
        lockable = self._lockable
        if not isinstance(locked, list) or not all(number in lockable for number in locked):
            raise InputError(
                f"locked = {safe_text.format_value(locked)}: a search does not vary such numbers"
            )
        if all(number in locked for number in lockable):
            raise InputError(
                "all numbers of the design are locked; unlock at least one for a search"
            )
        assert isinstance(self._open, LockingSearch)
        return self._open.with_locks(values, locked)

    def sought(self, message: Message) -> dict[str, Any]:
        """Return the design in a result of the command, also of one that is unfinished, without the
        numbers that are locked.
        """
        answer = _table(message, "answer")
        result = self._searching.sought(answer)
        locked = message.get("locked") or []
        moved = {path: value for path, value in result.values.items() if path not in locked}
        return {"values": moved, "sentence": result.sentence, "met": answer.get("met", True)}

    def works(self, message: Message) -> dict[str, Any]:
        """Write the file of the machine with changed numbers, and return the tasks of the requested
        exports.

        Raises InputError if an export does not exist, or if the file cannot be written.
        """
        model, numbers = self._values_and_model(message)[1], _table(message, "numbers")
        offered = {export.name: export for export in self._exports}
        names = message.get("names")
        if not isinstance(names, list) or not names:
            raise InputError("no export is selected; tick at least one")
        for name in names:
            if not isinstance(name, str) or name not in offered:
                raise InputError(
                    f"{name}: there is no such export; choose one of {', '.join(offered)}"
                )
        file = export_path(self.folder, self._open.name, "machine").with_suffix(".toml")
        folders = {name: export_path(self.folder, self._open.name, name) for name in names}
        works = [
            {
                "name": name,
                "folder": str(folder),
                "command": offered[name].command(file, folder, model, numbers),
            }
            for name, folder in folders.items()
        ]
        files.output_folder(file.parent)
        files.write_text(file, self._open.text(self._values_and_model(message)[0]))
        return {"works": works}

    @property
    def _lockable(self) -> list[str]:
        """Paths of the numbers that a search of the open machine can leave as they are."""
        machine = self._open
        return list(machine.lockable) if isinstance(machine, LockingSearch) else []

    @property
    def _searching(self) -> Searching:
        machine = self._open
        if not isinstance(machine, Searching) or not machine.search:
            raise InputError(f"{machine.name} cannot be optimised")
        return machine

    @property
    def _exports(self) -> list[Export]:
        return [*self._open.exports, ANIMATION]

    @property
    def _open(self) -> Shown:
        if self.machine is None:
            raise InputError("no machine is open")
        return self.machine

    def _values_and_model(self, message: Message) -> tuple[dict[str, float], str]:
        """Return values of all controls, and the model.

        Raises InputError if a number, value or model is invalid.
        """
        machine, values = self._open, _table(message, "values")
        controls = {control.path: control for control in machine.controls}
        for path, value in values.items():
            if path not in controls:
                raise InputError(
                    f"{path}: {machine.name} has no such number, or it cannot be changed"
                )
            if (
                isinstance(value, bool)
                or not isinstance(value, int | float)
                or not controls[path].lower <= value <= controls[path].upper
            ):
                low, high = controls[path].lower, controls[path].upper
                raise InputError(
                    f"{path} = {value}: the value must be between {low:g} and {high:g}"
                )
        model = message.get("model", machine.models[0])
        if model not in machine.models:
            raise InputError(
                f"model = {model}: there is no such model; choose one of "
                f"{', '.join(machine.models)}"
            )
        return {
            path: float(values.get(path, control.value)) for path, control in controls.items()
        }, model

    def _source(self, message: Message) -> str:
        if "text" in message:
            return self._loaded(message["text"], message.get("file", OPENED))
        name = message.get("name")
        if name in examples.list_examples(None, ".toml"):
            return str(name)
        names = list_sources(self.folder)
        if name not in names:
            raise InputError(
                f"{safe_text.quote_name(str(name))}: there is no such machine here; choose one of "
                f"{', '.join(names)}"
            )
        path = (self.folder / name).resolve()
        self._labels[str(path)] = name
        if path.parent != self.folder:
            raise InputError(
                f"{name}: there is no such machine here; it is a link to another folder"
            )
        if path != self._explicit and self._leads_outside(parse_toml(read_text(path), name)):
            raise InputError(
                f"{name}: its Python code is outside the studio's folder; open it by `planter "
                f"studio {name}`"
            )
        return str(path)

    def _leads_outside(self, table: Mapping[str, Any]) -> bool:
        """Return whether the functions of a mechanism's file may be outside the folder, by a path
        or a link.
        """
        code = f"{table.get(CODE, '')}.py"
        folders = (
            self.folder / str(table.get(CODE_FOLDER, "")),
            self.folder,
            self.folder / GENERATED,
        )
        return CODE in table and not all(
            (folder / code).resolve().is_relative_to(self.folder) for folder in folders
        )

    def _loaded(self, text: Any, label: Any) -> str:
        """Store the text of a file and return its path.

        Raises InputError if Python code belongs to the file.
        """
        if not isinstance(text, str) or not isinstance(label, str):
            raise InputError("text and file must be strings: the text of a file and its name")
        if len(text) > LARGEST:
            raise InputError(
                f"{safe_text.quote_name(label)}: at most {LARGEST} characters can be loaded"
            )
        table = parse_toml(text, safe_text.quote_name(label))
        if {CODE, CODE_FOLDER} & table.keys():
            raise InputError(
                f"{safe_text.quote_name(label)}: Python code belongs to this file ({CODE} or "
                f"{CODE_FOLDER}); "
                "open it by `planter studio FILE`"
            )
        self._texts += 1
        path = self._store(str(self._texts), OPENED, text)
        self._labels[str(path)] = safe_text.quote_name(label)
        return str(path)

    def _store(self, folder: str, name: str, text: str) -> Path:
        path = self.scratch / folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8", newline="\n")
        return path


def _table(message: Message, key: str) -> Mapping[str, Any]:
    table = message.get(key, {})
    if not isinstance(table, dict):
        raise InputError(f"{key} = {table}: a JSON object is required")
    return table


def _draw_scenes(scenes: Sequence[Scene]) -> list[dict[str, Any]]:
    return [{"picture": draw_picture(scene), "record": pack_scene(scene)} for scene in scenes]


MEMORY_BYTES = 2 * 2**30
"""Maximum address space of a process, including its libraries; every machine needs less than half
of it.
"""
REQUESTS = (
    "open",
    "seen",
    "refine_first",
    "refine",
    "finished",
    "checked",
    "details",
    "ends",
    "file",
    "wished",
    "plan",
    "search",
    "sought",
    "design",
    "works",
)
"""Methods of a session that a request can name."""
ECHOED = ("id", "opening", "title")
"""Keys of a message that an answer repeats, so that the page can assign it."""
FAILED = '{"error": '
"""Beginning of an answer that is an error."""


def main() -> None:
    """Answer requests; the first message has the folders of the session."""
    list(plugins.load_modules("show"))
    import_module(
        "planter.kernels.formulas"
    )  # takes longest to load, so that it is loaded before the first request
    workers.serve(_open_session, MEMORY_BYTES)


def _open_session(first: bytes) -> Callable[[bytes], bytes]:
    places = json.loads(first)
    session = Session(
        *(place and Path(place) for place in map(places.get, ("folder", "scratch", "explicit")))
    )
    if places["machine"]:
        with suppress(Exception):  # the page that asks for it gets the error
            session.prepare(places["machine"])

    def answer(message: bytes) -> bytes:
        request = json.loads(message)
        return answer_request(session, request["do"], request["message"]).encode("ascii")

    return answer


def answer_request(session: Session, name: str, message: Message) -> str:
    """Return the answer of a session to the request `name` as text; an exception becomes an error
    answer.
    """
    echoed = {key: message[key] for key in ECHOED if key in message}
    try:
        if name not in REQUESTS:
            raise ValueError(name)
        answer = getattr(session, name)(message)
        return _format_answer({**answer, **echoed})
    except PlanterError as error:
        sentence = session.in_page_words(error)
    except MemoryError:
        sentence = (
            f"this needs more memory than the {MEMORY_BYTES / 2**30:g} GB that a page's "
            f"machine may take"
        )
    except Exception as error:
        sentence = describe_error(error)
    return _format_answer({"error": safe_text.sanitise_line(sentence), **echoed})


def _format_answer(answer: Any) -> str:
    """Return standard JSON in ASCII; numbers that are not finite become null."""
    try:
        return json.dumps(answer, allow_nan=False)
    except ValueError:
        return json.dumps(_finite(answer), allow_nan=False)


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
