"""The file of a unit: a zip archive of description, C sources and binaries, the same bytes for the same content."""

from __future__ import annotations

import hashlib
import io
import zipfile
from collections.abc import Mapping
from importlib import resources

from planter.interchange.fmi2 import description
from planter.interchange.fmi2.description import Model

MAIN = "fmu.c"
"""The C file of a unit's sources that includes all others."""
SLAVE = "slave.c"
DAY = (1980, 1, 1, 0, 0, 0)
"""The date of every file in an archive: the earliest that there is."""
READABLE = 0o100644
"""What may be done with a file of an archive."""


def sources(model: Model, texts: Mapping[str, str]) -> tuple[str, dict[str, str]]:
    """The unit's guid, a hash of its description and sources, and the sources with it, by name.

    `texts` are the model's own; among them `MAIN`, where the guid is to stand in place of the word `GUID_OF_THIS`.
    """
    whole = dict(texts) | {SLAVE: resources.files(__package__).joinpath(SLAVE).read_text(encoding="utf-8")}
    content = [description.xml(model, [MAIN]), *(part.encode() for pair in sorted(whole.items()) for part in pair)]
    digest = hashlib.sha256(b"\0".join(content)).hexdigest()
    guid = "-".join((digest[:8], digest[8:12], digest[12:16], digest[16:20], digest[20:32]))
    return guid, whole | {MAIN: whole[MAIN].replace("GUID_OF_THIS", guid)}


def archive(model: Model, texts: Mapping[str, str], guid: str, binaries: Mapping[str, tuple[str, bytes]]) -> bytes:
    """A unit's file, from what `sources` gave and, by platform, file name and content of its binaries."""
    files = {"modelDescription.xml": description.xml(model, [MAIN], guid)}
    files |= {f"sources/{name}": text.encode() for name, text in sorted(texts.items())}
    files |= {f"binaries/{place}/{name}": content for place, (name, content) in sorted(binaries.items())}
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as zipped:
        for name, content in files.items():
            entry = zipfile.ZipInfo(name, DAY)
            entry.external_attr = READABLE << 16
            zipped.writestr(entry, content, zipfile.ZIP_DEFLATED)
    return stream.getvalue()
