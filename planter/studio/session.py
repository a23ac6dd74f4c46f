"""What a page asks and is told: messages in, messages out. Nothing is kept but the machine that is open."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from planter.errors import InputError, PlanterError
from planter.files import examples
from planter.report import files
from planter.studio import exports
from planter.view.channels import course, packed
from planter.view.exports import ANIMATION, Export
from planter.view.picture import picture
from planter.view.scene import Scene
from planter.view.subject import Searching, Shown, Values, Wishing, opened

LARGEST = 1_000_000
"""Letters of a file that is taken."""
OWN = "functions"
"""Key of files that say where Python code is: those are opened by name, from the folder of the studio, alone."""
Message = Mapping[str, Any]


class Session:
    """A page's talk with the studio of a `folder`, beyond which no file is read."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder.resolve()
        self.machine: Shown | None = None
        self._scratch = TemporaryDirectory(prefix="planter-")

    def close(self) -> None:
        """Remove what was put aside."""
        self._scratch.cleanup()

    def sources(self) -> list[str]:
        """Machines that can be opened by name: files of the folder, then built-in ones."""
        return [*sorted(path.name for path in self.folder.glob("*.toml")), *examples.names(None, ".toml")]

    def open(self, message: Message) -> dict[str, Any]:
        """A machine by name, or by the text of its file: what a page needs to show it."""
        self.machine = opened(self._source(message))
        return {
            "name": self.machine.name,
            "models": list(self.machine.models),
            "handles": [list(pair) for pair in self.machine.handles],
            "search": "Optimise" if isinstance(self.machine, Searching) and self.machine.search else None,
            "controls": [one.told() for one in self.machine.controls],
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
        return {"finished": _drawn([one.whole() for one in scenes])}

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

    def _beside(self, values: Values, model: str) -> dict[str, Any]:
        readings = [asdict(one) for one in self._open.readings(values, model)]
        return {"readings": readings, "course": course(self._open.scenes(values, model)[0])}

    def file(self, message: Message) -> str:
        """The machine's file with other numbers."""
        return self._open.text(self._asked(message)[0])

    def wished(self, message: Message) -> str:
        """That file with a path that a hand can draw about. Raises InputError for a machine that has none."""
        if not isinstance(self._open, Wishing) or not self._open.wishes:
            raise InputError(f"{self._open.name} has no path that could be drawn anew")
        return self._open.wished(self._asked(message)[0])

    def search(self, message: Message) -> tuple[Searching, list[str]]:
        """The machine, and the command that searches from its file, which is put aside.

        Raises InputError for a machine that has none.
        """
        machine, model = self._open, self._asked(message)[1]
        if not isinstance(machine, Searching) or not machine.search:
            raise InputError(f"{machine.name} has nothing to search for")
        place = Path(self._scratch.name) / "machine.toml"
        place.write_text(self.file(message), encoding="utf-8", newline="\n")
        chosen = ("--model", model) if len(machine.models) > 1 else ()
        return machine, [*machine.search, str(place), *chosen, "--json"]

    def works(self, message: Message) -> list[exports.Work]:
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
        found = [exports.Work(name, there, offered[name].command(file, there, model, numbers))
                 for name, there in places.items()]  # fmt: skip
        files.output_folder(file.parent)
        files.write_text(file, self.file(message))
        return found

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
            if not isinstance(value, int | float) or not known[path].lower <= value <= known[path].upper:
                low, high = known[path].lower, known[path].upper
                raise InputError(f"{path} = {value} is not allowed: it must be between {low:g} and {high:g}")
        model = message.get("model", machine.models[0])
        if model not in machine.models:
            raise InputError(f"model = {model} is not allowed: it must be one of {', '.join(machine.models)}")
        return {path: float(given.get(path, one.value)) for path, one in known.items()}, model

    def _source(self, message: Message) -> str:
        if "text" in message:
            return self._aside(str(message["text"]))
        name = str(message.get("name", ""))
        if name in examples.names(None, ".toml"):
            return name
        place = (self.folder / name).resolve()
        if not name.endswith(".toml") or place.parent != self.folder or not place.is_file():
            raise InputError(f"{name}: there is no such machine here: it must be one of {', '.join(self.sources())}")
        return str(place)

    def _aside(self, text: str) -> str:
        if len(text) > LARGEST:
            raise InputError(f"the file is not allowed: it must have at most {LARGEST} letters")
        if any(line.split("=")[0].strip() == OWN for line in text.splitlines()):
            raise InputError("the file is not allowed here: a mechanism of your own is opened by `planter studio FILE`")
        place = Path(self._scratch.name) / "opened.toml"
        place.write_text(text, encoding="utf-8", newline="\n")
        return str(place)


def _table(message: Message, key: str) -> Mapping[str, Any]:
    found = message.get(key, {})
    if not isinstance(found, dict):
        raise InputError(f"{key} = {found} is not allowed: it must be a JSON object")
    return found


def _drawn(scenes: Sequence[Scene]) -> list[dict[str, Any]]:
    return [{"picture": picture(one), "record": packed(one)} for one in scenes]


def told(error: PlanterError) -> dict[str, str]:
    """An error as a message."""
    return {"error": str(error)}
