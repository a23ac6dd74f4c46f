"""What a page asks and is told: messages in, messages out. Nothing is kept but the machine that is open."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

from planter import legible
from planter.errors import InputError, PlanterError
from planter.files import examples
from planter.files.derivation import GENERATED
from planter.files.text import parse_toml, read_text
from planter.report import files
from planter.studio import exports
from planter.studio.words import to_page_words
from planter.view.channels import course, packed
from planter.view.exports import ANIMATION, Export
from planter.view.picture import picture
from planter.view.scene import Scene
from planter.view.subject import STEPS, Searching, Shown, Values, Wishing, farthest, opened

LARGEST = 1_000_000
"""Letters of a file that is taken."""
OWN, PLACE = "functions", "folder"
"""Keys of a file that say which Python code belongs to it, and in which folder that is."""
ENDS_S = 4.0
"""Time that finding the ends of all numbers may take, as far as the first one tells."""
OPENED = "opened.toml"
"""Name of a loaded file that has none."""
Message = Mapping[str, Any]


def sources(folder: Path) -> list[str]:
    """Return the machines that can be opened by name: files of the folder, then built-in ones."""
    return [*sorted(path.name for path in folder.glob("*.toml")), *examples.names(None, ".toml")]


class Session:
    """A page's talk with the studio of a `folder`, whose machines are opened by name.

    Files that a page loads are put aside in `scratch`. `explicit` is the file that the user named on the command line:
    what code belongs to it may stand anywhere.
    """

    def __init__(self, folder: Path, scratch: Path, explicit: Path | None = None) -> None:
        self.folder, self.scratch = folder.resolve(), scratch
        self._explicit = explicit and explicit.resolve()
        self.machine: Shown | None = None
        self._texts = 0
        self._labels: dict[str, str] = {}

    def in_page_words(self, error: PlanterError) -> str:
        """Return the sentence of an error with files called as the page calls them."""
        return to_page_words(error.message, self._labels)

    def open(self, message: Message) -> dict[str, Any]:
        """A machine by name, or by the text of its file: what a page needs to show it."""
        self.machine = opened(self._source(message))
        return {"opened": self._description()}

    def _description(self) -> dict[str, Any]:
        assert self.machine is not None
        return {
            "name": self.machine.name,
            "models": list(self.machine.models),
            "handles": [list(pair) for pair in self.machine.handles],
            "search": "Optimise" if isinstance(self.machine, Searching) and self.machine.search else None,
            "controls": [one.to_json() for one in self.machine.controls],
            "wishes": isinstance(self.machine, Wishing) and self.machine.wishes,
            "exports": [asdict(one) for one in self._exports],
        }

    def seen(self, message: Message) -> dict[str, Any]:
        """The machine with other numbers: scenes and readings."""
        values, model = self._asked(message)
        return {
            "scenes": _drawn(self._open.scenes(values, model)),
            "readings": [asdict(one) for one in self._open.readings(values, model)],
        }

    def finished(self, message: Message) -> dict[str, Any]:
        """Its scenes with all that there is to see; nothing where they have that at once."""
        scenes = self._open.scenes(*self._asked(message))
        if not any(one.later for one in scenes):
            return {}
        return {"finished": _drawn([one.with_details() for one in scenes])}

    def checked(self, message: Message) -> dict[str, Any]:
        """The requirements of the machine with other numbers."""
        return {"checks": [asdict(one) for one in self._open.checks(*self._asked(message))]}

    def details(self, message: Message) -> dict[str, Any]:
        """What the machine with other numbers is sized by, and what its other models say."""
        values, model = self._asked(message)
        others = [name for name in self._open.models if name != model]
        return {
            "details": [asdict(one) for one in self._open.details(values, model)],
            "beside": [{"model": name, **self._beside(values, name)} for name in others],
        }

    def ends(self, message: Message) -> dict[str, Any]:
        """How far each number can be moved from where the others are; nothing where finding that takes too long."""
        values, model = self._asked(message)

        def attempt(path: str, number: float) -> None:
            self._open.readings({**values, path: number}, model)

        first = self._open.controls[0]
        self._open.readings(values, model)  # what is computed once is not counted
        begun = time.process_time()
        attempt(first.path, values[first.path] + (first.upper - values[first.path]) / STEPS)
        if 2 * len(values) * (time.process_time() - begun) > ENDS_S:
            return {}
        found = {}
        for one in self._open.controls:
            try_number = partial(attempt, one.path)
            found[one.path] = [farthest(values[one.path], end, try_number) for end in (one.lower, one.upper)]
        return {"ends": found}

    def _beside(self, values: Values, model: str) -> dict[str, Any]:
        readings = [asdict(one) for one in self._open.readings(values, model)]
        return {"readings": readings, "course": course(self._open.scenes(values, model)[0])}

    def file(self, message: Message) -> dict[str, Any]:
        """The machine's file with other numbers."""
        return {"file": self._open.text(self._asked(message)[0])}

    def wished(self, message: Message) -> dict[str, Any]:
        """That file with a path that a hand can draw about. Raises InputError for a machine that has none."""
        if not isinstance(self._open, Wishing) or not self._open.wishes:
            raise InputError(f"{self._open.name} has no path that could be drawn anew")
        return {"wished": self._open.wished(self._asked(message)[0])}

    def search(self, message: Message) -> dict[str, Any]:
        """The command that searches from the machine's file, which is put aside.

        Raises InputError for a machine that has none.
        """
        machine, model = self._open, self._asked(message)[1]
        if not isinstance(machine, Searching) or not machine.search:
            raise InputError(f"{machine.name} has nothing to search for")
        place = self._put_aside("search", "machine.toml", machine.text(self._asked(message)[0]))
        chosen = ("--model", model) if len(machine.models) > 1 else ()
        return {"command": [*machine.search, str(place), *chosen, "--json"], "labels": {str(place): machine.name}}

    def sought(self, message: Message) -> dict[str, Any]:
        """What the search has found, from the result of its command."""
        if not isinstance(self._open, Searching):
            raise InputError(f"{self._open.name} has nothing to search for")
        found = self._open.sought(_table(message, "answer"))
        return {"optimum": dict(found.values), "sentence": found.sentence}

    def works(self, message: Message) -> dict[str, Any]:
        """What is to be written of the machine with other numbers; its file is written first.

        Raises InputError for what it does not offer, and where nothing can be written.
        """
        model, numbers = self._asked(message)[1], _table(message, "numbers")
        offered = {one.name: one for one in self._exports}
        wanted = message.get("names")
        if not isinstance(wanted, list) or not wanted:
            raise InputError("nothing was ticked to be written")
        for name in wanted:
            if not isinstance(name, str) or name not in offered:
                raise InputError(f"{name} is not allowed: it must be one of {', '.join(offered)}")
        file = exports.place(self.folder, self._open.name, "machine").with_suffix(".toml")
        places = {name: exports.place(self.folder, self._open.name, name) for name in wanted}
        found = [{"name": name, "there": str(there), "command": offered[name].command(file, there, model, numbers)}
                 for name, there in places.items()]  # fmt: skip
        files.output_folder(file.parent)
        files.write_text(file, self._open.text(self._asked(message)[0]))
        return {"works": found}

    @property
    def _exports(self) -> list[Export]:
        return [*self._open.exports, ANIMATION]

    @property
    def _open(self) -> Shown:
        if self.machine is None:
            raise InputError("no machine is open")
        return self.machine

    def _asked(self, message: Message) -> tuple[dict[str, float], str]:
        """Numbers of all controls, within their ends, and the model. Raises InputError for what is none of these."""
        machine, given = self._open, _table(message, "values")
        known = {one.path: one for one in machine.controls}
        for path, value in given.items():
            if path not in known:
                raise InputError(f"{path} is not allowed: it is no number of {machine.name} that can be changed")
            if (
                isinstance(value, bool)
                or not isinstance(value, int | float)
                or not known[path].lower <= value <= known[path].upper
            ):
                low, high = known[path].lower, known[path].upper
                raise InputError(f"{path} = {value} is not allowed: it must be between {low:g} and {high:g}")
        model = message.get("model", machine.models[0])
        if model not in machine.models:
            raise InputError(f"model = {model} is not allowed: it must be one of {', '.join(machine.models)}")
        return {path: float(given.get(path, one.value)) for path, one in known.items()}, model

    def _source(self, message: Message) -> str:
        if "text" in message:
            return self._loaded(message["text"], message.get("file", OPENED))
        name = message.get("name")
        if name in examples.names(None, ".toml"):
            return str(name)
        known = sources(self.folder)
        if name not in known:
            raise InputError(
                f"{legible.name(str(name))}: there is no such machine here: it must be one of {', '.join(known)}"
            )
        place = (self.folder / name).resolve()
        self._labels[str(place)] = name
        if place.parent != self.folder:
            raise InputError(f"{name}: there is no such machine here: it is a link to another folder")
        if place != self._explicit and self._leads_outside(parse_toml(read_text(place), name)):
            raise InputError(
                f"{name} is not allowed here, since its Python code is outside the studio's folder: "
                f"it must be opened by `planter studio {name}`"
            )
        return str(place)

    def _leads_outside(self, table: Mapping[str, Any]) -> bool:
        """Whether the functions of a mechanism's file may stand outside the folder, by a path or a link."""
        code = f"{table.get(OWN, '')}.py"
        places = (self.folder / str(table.get(PLACE, "")), self.folder, self.folder / GENERATED)
        return OWN in table and not all((one / code).resolve().is_relative_to(self.folder) for one in places)

    def _loaded(self, text: Any, label: Any) -> str:
        """Where the text of a file was put aside. Raises InputError for one that says where Python code is."""
        if not isinstance(text, str) or not isinstance(label, str):
            raise InputError("text and file are not allowed: they must be a file's text and its name")
        if len(text) > LARGEST:
            raise InputError(f"{legible.name(label)} is not allowed: it must have at most {LARGEST} letters")
        table = parse_toml(text, legible.name(label))
        if {OWN, PLACE} & table.keys():
            raise InputError(
                f"{legible.name(label)} is not allowed here, since Python code belongs to it ({OWN} or {PLACE}): "
                "a mechanism of your own is opened by `planter studio FILE`"
            )
        self._texts += 1
        place = self._put_aside(str(self._texts), OPENED, text)
        self._labels[str(place)] = legible.name(label)
        return str(place)

    def _put_aside(self, folder: str, name: str, text: str) -> Path:
        place = self.scratch / folder / name
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text(text, encoding="utf-8", newline="\n")
        return place


def _table(message: Message, key: str) -> Mapping[str, Any]:
    found = message.get(key, {})
    if not isinstance(found, dict):
        raise InputError(f"{key} = {found} is not allowed: it must be a JSON object")
    return found


def _drawn(scenes: Sequence[Scene]) -> list[dict[str, Any]]:
    return [{"picture": picture(one), "record": packed(one)} for one in scenes]
