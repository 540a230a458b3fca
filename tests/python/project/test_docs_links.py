"""Every link of the documentation leads to a file, and to a heading of it."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from pathlib import Path

from extension.cpp import public_headers
from extension.pages import GROUPS, made
from plica import __all__ as public
from repository import ROOT

MADE = {ROOT / "docs" / name: text for name, text in made().items()}
FILES = [ROOT / "README.md", ROOT / "benchmarks" / "README.md", *(ROOT / "docs").rglob("*.md")]
PAGES = {page: page.read_text(encoding="utf-8") for page in sorted(FILES)} | MADE
BUILT = ROOT / "docs" / "gallery"  # by sphinx-gallery, a page a tutorial


def anchors(page: Path) -> set[str]:
    """Of its headings, as they are made of them where Markdown is shown."""
    headings = re.findall(r"(?m)^#+ (.*)$", PAGES[page])
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def broken(page: Path, text: str) -> Iterator[str]:
    """Links of a text on the page that lead nowhere."""
    for link in re.findall(r"\]\(([^)\s]+)\)", text):
        if link.startswith(("http:", "https:", "mailto:")):
            continue
        path, _, anchor = link.partition("#")
        target = Path(os.path.normpath(page.parent / path)) if path else page
        if target.parent == BUILT:
            target = ROOT / "docs" / "tutorials" / f"{target.stem}.py"
        if not (target.exists() or target in PAGES) or (
            anchor and target.suffix == ".md" and anchor not in anchors(target)
        ):
            yield f"{page.relative_to(ROOT)}: {link}"


def test_links_lead_somewhere() -> None:
    assert len(PAGES) > 20
    assert [link for page, text in PAGES.items() for link in broken(page, text)] == []


def test_a_link_that_leads_nowhere_is_found() -> None:
    page = ROOT / "README.md"
    wrong = "[a](docs/none.md) [b](docs/verify.md#none) [c](docs/verify.md#what-is-left-out) [d](https://x.y)"
    assert list(broken(page, wrong)) == ["README.md: docs/none.md", "README.md: docs/verify.md#none"]


def test_every_public_name_has_a_page() -> None:
    index = PAGES[ROOT / "docs" / "reference" / "python.md"]
    for name in sorted({*public} - {"__version__"}):
        assert f"[`{name}`](python/{name}.md)" in index
        assert len(PAGES[ROOT / "docs" / "reference" / "python" / f"{name}.md"]) > 40
    assert all(f"## {title}\n" in index for title in GROUPS)


def test_every_public_header_of_the_engine_has_a_page() -> None:
    headers = list(public_headers())
    assert len(headers) > 20
    assert len({path.name for _, path in headers}) == len(headers)  # pages name them without their folder
    index = PAGES[ROOT / "docs" / "reference" / "cpp.md"]
    for module, path in headers:
        assert path.is_file()
        assert f"[`{module}`](cpp/{module}.md)" in index
        assert (
            f".. doxygenfile:: {path.name}\n" in PAGES[ROOT / "docs" / "reference" / "cpp" / f"{module}.md"]
        )
