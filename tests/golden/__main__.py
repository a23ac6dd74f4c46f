"""Write the results of all commands by a given `planter` to kept.json: `python -m tests.golden PLANTER OWN DOCS`.

OWN is the folder of the derived examples of the guide, DOCS that of the guide's own files.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from tests.golden import record


def run(planter: str, words: list[str], places: dict[str, str]) -> record.Entries:
    with TemporaryDirectory() as folder:
        arguments = [planter, *(word.format(**places) for word in words), "--json"]
        environment = os.environ | {"PLANTER_KERNELS": "casadi-vm"}
        result = subprocess.run(arguments, cwd=folder, env=environment, capture_output=True, text=True, check=False)
        if result.returncode:
            sys.exit(f"{' '.join(arguments)}: {result.stderr}")
        return record.flatten(json.loads(result.stdout), Path(folder))


def main(planter: str, examples: str, docs: str) -> None:
    places = {"own": str(Path(examples).absolute()), "docs": str(Path(docs).absolute())}
    commands = record.list_commands(False) | record.list_commands(True)
    entry = {}
    for name, words in commands.items():
        print(name, flush=True)
        entry[name] = run(str(Path(planter).absolute()), words, places)
    lines = ",\n".join(f"{json.dumps(name)}: {json.dumps(entries)}" for name, entries in entry.items())
    (record.FOLDER / "kept.json").write_text(f"{{\n{lines}\n}}\n", encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
