"""Generated folders on the disk: written, added to, compared."""

from __future__ import annotations

from pathlib import Path

GENERATED = Path(__file__).parents[2] / "generated"
"""Where a checkout keeps what is derived."""


def write(folder: Path, content: dict[str, str], others: frozenset[str] = frozenset()) -> None:
    """Write every text; nothing that stands there besides is kept, but what other parts wrote."""
    for stray in strays(folder, content):
        if stray.relative_to(folder).as_posix() not in others:
            stray.unlink()
    add(folder, content)


def add(folder: Path, content: dict[str, str]) -> None:
    """Write every text; what stands there besides is left alone."""
    for name, text in content.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8", newline="\n")


def differences(folder: Path, content: dict[str, str]) -> list[str]:
    """What is missing, changed or stray in a folder, a line each."""
    return [*(f"stray: {path.relative_to(folder)}" for path in strays(folder, content)), *changes(folder, content)]


def changes(folder: Path, content: dict[str, str]) -> list[str]:
    """What is missing or changed in a folder, a line each."""
    found = []
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
