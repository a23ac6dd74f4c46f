"""`python -m planter.records` writes the schemas that the package ships."""

from __future__ import annotations

from planter.records.schema import FOLDER, format_schemas


def main() -> None:
    """Write all schemas, and remove those of commands that no longer exist."""
    FOLDER.mkdir(exist_ok=True)
    schemas = format_schemas()
    for path in FOLDER.glob("*.json"):
        if path.name not in schemas:
            path.unlink()
    for name, text in schemas.items():
        (FOLDER / name).write_text(text, encoding="utf-8", newline="\n")


if __name__ == "__main__":
    main()
