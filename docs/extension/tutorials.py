"""A tutorial that ran without a picture fails the build, as one that raises does."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from sphinx.errors import ExtensionError


def setup(app: Any) -> None:
    app.connect("build-finished", _look)


def _look(app: Any, error: Exception | None) -> None:
    if error is not None:
        return
    pictures = Path(app.srcdir, "gallery", "images")
    for tutorial in sorted(Path(app.srcdir, "tutorials").glob("[0-9]*.py")):
        if not any(pictures.glob(f"sphx_glr_{tutorial.stem}_*.png")):
            raise ExtensionError(f"{tutorial.name} has no picture; a tutorial must end with one")
