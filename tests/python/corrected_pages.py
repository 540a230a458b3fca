"""The page of ``plica masks --page`` read without a browser, and what it saves, made as it makes it."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np

__all__ = ["page_content", "saved", "unpacked"]


def page_content(page: Path) -> dict[str, Any]:
    """All that the page was told."""
    found = re.search(r"^const page = (.*);$", page.read_text(encoding="utf-8"), re.MULTILINE)
    assert found is not None
    content: dict[str, Any] = json.loads(found[1])
    return content


def saved(page: Path, file: Path, **corrected: Any) -> Path:
    """A file as the page saves it, with these masks (by frame), midline, region and scale."""
    told = page_content(page)
    content = {"plica_corrections": told["version"], "recording": told["recording"], "view": told["view"]}
    if "masks" in corrected:
        corrected["masks"] = {str(frame): packed(mask) for frame, mask in corrected["masks"].items()}
    file.write_text(json.dumps(content | corrected), encoding="utf-8")
    return file


def packed(mask: np.ndarray) -> list[int]:
    """The page's function of this name, pixel by pixel."""
    runs, value, run = [], False, 0
    for pixel in mask.ravel().tolist():
        if pixel == value:
            run += 1
        else:
            runs.append(run)
            value, run = pixel, 1
    return [*runs, run]


def unpacked(runs: list[int], told: dict[str, Any]) -> np.ndarray:
    """(h, w) bool, the page's function of this name."""
    flat = [k % 2 == 1 for k, run in enumerate(runs) for _ in range(run)]
    return np.array(flat).reshape(told["recording"]["height"], told["recording"]["width"])
