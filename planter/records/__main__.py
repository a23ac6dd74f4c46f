"""`python -m planter.records` writes the schemas that the package ships."""

from __future__ import annotations

from planter.records.schema import FOLDER, texts


def main() -> None:
    """Writes every schema, and removes those of commands that are no more."""
    FOLDER.mkdir(exist_ok=True)
    wanted = texts()
    for path in FOLDER.glob("*.json"):
        if path.name not in wanted:
            path.unlink()
    for name, text in wanted.items():
        (FOLDER / name).write_text(text, encoding="utf-8", newline="\n")


if __name__ == "__main__":
    main()
