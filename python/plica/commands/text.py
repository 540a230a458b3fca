"""Text layout of commands."""

from __future__ import annotations

import re
import shutil
import textwrap

__all__ = ["first_sentence", "hanging"]


def first_sentence(text: str) -> str:
    """Up to the first full stop before a capital ("Sec. 3" goes on), without it."""
    return re.split(r"\.\s+(?=[A-Z`\"])", " ".join(text.split()))[0].rstrip(".")


def hanging(name: str, text: str, indent: int) -> str:
    """A name followed by a text with hanging indent, wrapped to the width of the terminal."""
    width = max(shutil.get_terminal_size((100, 24)).columns, indent + 30)
    filled = textwrap.fill(text, width, initial_indent=" " * indent, subsequent_indent=" " * indent)
    return f"{name:<{indent}}{filled[indent:]}"
