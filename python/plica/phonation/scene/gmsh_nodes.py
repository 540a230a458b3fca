"""Whether the elements of a Gmsh file (version 2, text) name nodes that are in it."""

from __future__ import annotations

from pathlib import Path

__all__ = ["missing_node"]


def missing_node(path: Path) -> tuple[int, int] | None:
    """The number of the first element with a node that the file does not have, and the node; None if there is
    none, or the file is of another version or binary."""
    lines = iter(path.read_text(encoding="latin-1").splitlines())
    nodes: set[int] = set()
    for line in lines:
        heading = line.strip()
        try:
            if heading == "$MeshFormat":
                version, kind = next(lines).split()[:2]
                if not version.startswith("2") or kind != "0":
                    return None
            elif heading == "$Nodes":
                nodes = {int(next(lines).split()[0]) for _ in range(int(next(lines)))}
            elif heading == "$Elements":
                for _ in range(int(next(lines))):
                    number, _, tags, *rest = map(int, next(lines).split())
                    for node in rest[tags:]:
                        if node not in nodes:
                            return number, node
        except (ValueError, StopIteration, IndexError):
            return None  # broken in another way, which the reader tells
    return None
