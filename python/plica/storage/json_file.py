"""Write small results as JSON."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from plica.storage.files import replaced

__all__ = ["write_json"]


def write_json(content: Any, path: Path) -> Path:
    """Write JSON with finite numbers, replacing the file atomically, and return the path."""
    text = json.dumps(content, indent=2, allow_nan=False)

    def fill(draft: Path) -> None:
        draft.write_text(text + "\n", encoding="utf-8")

    replaced(path, fill)
    return path
