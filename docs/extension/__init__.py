"""What the site needs beside Sphinx: pages made of the code, records, formulas, links out of docs."""

from __future__ import annotations

from typing import Any

from extension import cpp, formulas, links, pages, records, tutorials


def setup(app: Any) -> dict[str, Any]:
    """Called by Sphinx."""
    for part in (cpp, formulas, links, pages, records, tutorials):
        part.setup(app)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
