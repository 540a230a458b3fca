"""The records that two files or two directories have of the same cases."""

from __future__ import annotations

from pathlib import Path

from plica.bench.record import Record, read
from plica.errors import InvalidInput

__all__ = ["pairs"]


def pairs(before: Path, after: Path) -> list[tuple[Record, Record]]:
    """One of two files, or one for each case of both directories; raises InvalidInput where there is none."""
    if before.is_dir() != after.is_dir():
        raise InvalidInput(f"bench compare: {before} and {after}; must be two records or two directories.")
    if not before.is_dir():
        return [(read(before), read(after))]
    names = [path.name for path in sorted(before.glob("*.json")) if (after / path.name).exists()]
    if not names:
        raise InvalidInput(
            f"bench compare: {before} and {after} have no case in common; must have one at least."
        )
    return [(read(before / name), read(after / name)) for name in names]
