"""The page of works: what results rest on, as `planter about cite` tells it."""

from __future__ import annotations

from collections.abc import Iterator

from planter.cli.references import cite_work, load_references

HEAD = """\
# Works

The papers and methods behind results, and the commands that rest on them; `planter about cite COMMAND --bibtex` prints
them as entries for BibTeX.

| work | for | commands |
|---|---|---|
"""
DOI = "https://doi.org/"


def rows() -> Iterator[str]:
    """A work with its DOI as a link, what it is for, and what rests on it."""
    index = load_references()
    for key, fields in index.works.items():
        text, doi = cite_work(key).text.replace("|", "\\|").replace("^", "\\^"), fields.get("doi")
        linked = text.replace(f"doi:{doi}", f"[doi:{doi}]({DOI}{doi})") if doi else text
        resting = ", ".join(
            f"`{command}`" for command, keys in sorted(index.commands.items()) if key in keys
        )
        yield f"| {linked} | {fields.get('for', 'this program')} | {resting or 'all'} |"


def page() -> str:
    """The page."""
    return HEAD + "\n".join(rows()) + "\n"
