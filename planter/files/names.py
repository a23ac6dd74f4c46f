"""Names of machines, quantities and designs as names of files."""

from __future__ import annotations

import re
import unicodedata

LONGEST = 80
"""Characters of a file's name without its ending."""
_LONGEST_BYTES = 200
"""The same in UTF-8: file systems allow 255 bytes for the whole name."""
_RESERVED = re.compile(r"(CON|PRN|AUX|NUL|COM\d|LPT\d)(\..*)?", re.IGNORECASE)
"""Names that Windows keeps for devices, whatever follows the dot."""


def file_name(name: str) -> str:
    """Return a name as the name of a file without its ending, on every system, in the folder that it is put in.

    Letters and digits of any script stay, what separates folders or cannot be seen becomes `_`.

    >>> file_name("wang2017"), file_name("/etc/passwd"), file_name("../a b"), file_name("nul"), file_name("..")
    ('wang2017', '_etc_passwd', '_a b', '_nul', '_')
    """
    plain = "".join(sign if _is_allowed(sign) else "_" for sign in unicodedata.normalize("NFC", name))
    short = plain.lstrip(". -")[:LONGEST].encode()[:_LONGEST_BYTES].decode(errors="ignore").rstrip(". ")
    return f"_{short}" if not short or _RESERVED.fullmatch(short) else short


def _is_allowed(sign: str) -> bool:
    return sign.isalnum() or sign in "_-+.,=@() " or unicodedata.category(sign) in ("Mn", "Mc")
