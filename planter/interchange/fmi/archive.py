"""The file of a unit: a zip archive of description, C sources and libraries, the same bytes for the same content."""

from __future__ import annotations

import hashlib
import io
import zipfile
from collections.abc import Mapping
from importlib import resources
from typing import Protocol

from planter.interchange.fmi import version2, version3
from planter.interchange.fmi.model import MAIN, Model

TOKEN = "TOKEN_OF_THIS"
"""Stands in `MAIN` for what tells a unit from others."""
INTERFACE = "interface.c"
"""What `MAIN` includes last."""
DAY = (1980, 1, 1, 0, 0, 0)
"""The date of every file in an archive: the earliest that there is."""
READABLE = 0o100644
"""What may be done with a file of an archive."""


class Version(Protocol):
    """A version of the interface: its name, its C file, its folders of libraries by platform, its descriptions."""

    NAME: str
    INTERFACE: str
    FOLDERS: dict[str, str]

    def files(self, model: Model, token: str) -> dict[str, bytes]:
        """Descriptions by their paths in an archive."""


VERSIONS: dict[str, Version] = {"2.0": version2, "3.0": version3}


def sources(version: Version, model: Model, texts: Mapping[str, str]) -> tuple[str, dict[str, str]]:
    """The unit's token, a hash of its description and sources, and the sources with it, by name.

    `texts` are the model's own; among them `MAIN`, which holds the word `TOKEN`.
    """
    folder = resources.files(__package__)
    fixed = {INTERFACE: version.INTERFACE, "core.c": "core.c"}
    code = dict(texts) | {name: folder.joinpath(file).read_text(encoding="utf-8") for name, file in fixed.items()}
    parts = [*version.files(model, TOKEN).values(), *(part.encode() for pair in sorted(code.items()) for part in pair)]
    digest = hashlib.sha256(b"\0".join(parts)).hexdigest()
    token = "-".join((digest[:8], digest[8:12], digest[12:16], digest[16:20], digest[20:32]))
    return token, code | {MAIN: code[MAIN].replace(TOKEN, token)}


def archive(
    version: Version, model: Model, texts: Mapping[str, str], token: str, libraries: Mapping[str, tuple[str, bytes]]
) -> bytes:
    """A unit's file, from what `sources` gave and, by platform, file name and content of its libraries."""
    files = version.files(model, token)
    files |= {f"sources/{name}": text.encode() for name, text in sorted(texts.items())}
    files |= {f"binaries/{version.FOLDERS[place]}/{name}": data for place, (name, data) in sorted(libraries.items())}
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as zipped:
        for name, content in files.items():
            entry = zipfile.ZipInfo(name, DAY)
            entry.external_attr = READABLE << 16
            zipped.writestr(entry, content, zipfile.ZIP_DEFLATED)
    return stream.getvalue()
