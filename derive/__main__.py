"""`python -m derive` writes `generated/`; `python -m derive --check` compares both ways and writes nothing."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from derive.pipeline import texts

GENERATED = Path(__file__).parents[1] / "generated"


def write(folder: Path, content: dict[str, str]) -> None:
    """Write every text; nothing that stands there besides is kept."""
    for stray in strays(folder, content):
        stray.unlink()
    for name, text in content.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8", newline="\n")


def differences(folder: Path, content: dict[str, str]) -> list[str]:
    """What is missing, changed or stray in a folder, a line each."""
    found = [f"stray: {path.relative_to(folder)}" for path in strays(folder, content)]
    for name, text in sorted(content.items()):
        path = folder / name
        if not path.is_file():
            found.append(f"missing: {name}")
        elif path.read_bytes() != text.encode():
            found.append(f"changed: {name}")
    return found


def strays(folder: Path, content: dict[str, str]) -> list[Path]:
    files = (p for p in folder.rglob("*") if p.is_file() and "__pycache__" not in p.parts)
    return sorted(p for p in files if p.relative_to(folder).as_posix() not in content)


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m derive", description=__doc__)
    parser.add_argument("--check", action="store_true", help="compare with generated/ instead of writing it")
    arguments = parser.parse_args()
    content = texts()
    if not arguments.check:
        write(GENERATED, content)
        print(f"generated/: {len(content)} files")
        return 0
    found = differences(GENERATED, content)
    print("\n".join(found) or f"generated/ is up to date: {len(content)} files")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
