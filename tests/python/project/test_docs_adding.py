"""The page of what is added where names files and folders that there are."""

from __future__ import annotations

import re

from repository import ROOT

PAGE = (ROOT / "docs" / "adding.md").read_text(encoding="utf-8")
NAMED = re.findall(r"`([^`\s]+/[^`\s]+)`", PAGE)


def test_every_path_is_there() -> None:
    assert len(NAMED) > 40
    assert [path for path in NAMED if not (ROOT / path).exists()] == []


def test_every_table_says_what_fails() -> None:
    rows = [line.split(" | ") for line in PAGE.splitlines() if line.startswith("| ")]
    assert len(rows) > 25
    assert all(len(row) == 3 and row[2].strip(" |") for row in rows)
