"""docs/thesis.md has the lines that benchmarks/thesis writes."""

from __future__ import annotations

import re

from benchmarks.thesis.page import HEAD, filled
from repository import ROOT


def blocks() -> list[str]:
    """Paragraphs and points of the page."""
    page = (ROOT / "docs" / "thesis.md").read_text(encoding="utf-8")
    return [point for block in page.strip().split("\n\n") for point in re.split(r"\n(?=- )", block)]


def test_lines_of_the_page_are_broken_as_it_is_made() -> None:
    text = [block for block in blocks() if not block.startswith(("#", "!["))]
    assert len(text) > 30
    for block in text:
        assert block == filled(block, "  " if block.startswith("- ") else "")


def test_the_page_begins_as_it_is_made() -> None:
    given = {"engine": r"\w+", "mesh": "Mesh: .*", "duration": r"[\d.]+", "last": r"\d+"}
    for paragraph, block in zip(HEAD.split("\n\n"), blocks()[1:], strict=False):
        pattern = re.escape(" ".join(paragraph.split()))
        for name, value in given.items():
            pattern = re.sub(rf"\\{{{name}(:g)?\\}}", value.replace("\\", r"\\"), pattern)
        assert re.fullmatch(pattern, " ".join(block.split()))
