"""Small results as JSON."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from plica.storage.files import replaced

__all__ = ["write_json"]


def write_json(content: Any, path: Path) -> Path:
    """Write JSON, numbers finite, and return the path; a reader sees the old file or the new one, whole."""
    text = json.dumps(content, indent=2, allow_nan=False)

    def fill(draft: Path) -> None:
        draft.write_text(text + "\n", encoding="utf-8")

    replaced(path, fill)
    return path
