"""Small results as JSON; what is read back is guarded by a checksum.

The checksum is that of the content, not of the text, which may be laid out otherwise.
"""

from __future__ import annotations

import json
import zlib
from pathlib import Path
from typing import Any

from plica.errors import Damaged
from plica.storage.files import require_file, storage_errors, write_text

__all__ = ["read_json", "write_json"]

_CHECKSUM = "checksum"


def write_json(content: Any, path: Path, *, guarded: bool = False) -> Path:
    """Write JSON with finite numbers, replacing the file atomically, and return the path.

    guarded: an object to be read back by `read_json`; its checksum is written as its last entry.
    """
    if guarded:
        content = {**content, _CHECKSUM: _checksum(content)}
    return write_text(json.dumps(content, indent=2, allow_nan=False) + "\n", path)


def read_json(path: Path, hint: str) -> dict[str, Any]:
    """The object of a file that `write_json` guarded.

    Raises
    ------
    Damaged
        If the content is not what was written; the message ends with `hint`, what to do then.
    StorageFailed
        If the system refuses to read it.
    """
    require_file(path, str(path))
    with storage_errors(path, "read"):
        raw = path.read_bytes()
    try:
        content = json.loads(raw)
        stated = content.pop(_CHECKSUM)
        whole = stated == _checksum(content)
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        whole = False
    if not whole:
        raise Damaged(
            f"{path}: its content is not what its checksum says; must be as plica wrote it. It is damaged, "
            f"was edited, or is from an earlier version. {hint}."
        )
    return content  # type: ignore[no-any-return]


def _checksum(content: Any) -> str:
    """CRC-32 of the content in one form: keys sorted, no spaces."""
    text = json.dumps(content, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return f"crc32 {zlib.crc32(text.encode()):08x}"
