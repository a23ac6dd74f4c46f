"""Write `generated/`: code (`python -m derive`) or verdicts (`python -m derive audit`), or compare (`--check`)."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from .pipeline import PARTS, VERDICTS

GENERATED = Path(__file__).parents[1] / "generated"


def write(folder: Path, content: dict[str, str], others: frozenset[str] = frozenset()) -> None:
    """Write every text; nothing that stands there besides is kept, but what other parts wrote."""
    for stray in strays(folder, content):
        if stray.relative_to(folder).as_posix() not in others:
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
    parser.add_argument("part", nargs="?", choices=PARTS, default="code", help="what to write (default: code)")
    parser.add_argument("--check", action="store_true", help="derive everything and compare with generated/, both ways")
    arguments = parser.parse_args()
    if arguments.check:
        content = {name: text for part in PARTS.values() for name, text in part(None).items()}
        found = differences(GENERATED, content)
        print("\n".join(found) or f"generated/ is up to date: {len(content)} files")
        return 1 if found else 0
    content = PARTS[arguments.part](GENERATED / "audit.json")
    write(GENERATED, content, kept(arguments.part))
    print(f"generated/: {len(content)} files of {arguments.part}")
    return 0


def kept(part: str) -> frozenset[str]:
    """Names of the verdicts, when code is written; everything but them, when they are."""
    if part == "code":
        return VERDICTS
    return frozenset(p.relative_to(GENERATED).as_posix() for p in GENERATED.rglob("*"))


if __name__ == "__main__":
    sys.exit(main())
