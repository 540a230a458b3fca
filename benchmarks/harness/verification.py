"""``verification``: the rows of ``plica verify`` as records, one a subject."""

from __future__ import annotations

import argparse
from typing import Any

from plica.commands.arguments import add_command

__all__ = ["add_commands"]


def add_commands(benches: Any) -> None:
    """Add it to the commands."""
    add_command(
        benches,
        "verification",
        _verification,
        "keep the rows of plica verify as docs/records/verify_SUBJECT.json (30 s; of committed sources)",
    )


def _verification(options: argparse.Namespace) -> int:
    from benchmarks.harness.study import record
    from plica.verify.subjects import SUBJECTS, verify
    from plica.verify.text import COLUMNS, cells

    for subject in SUBJECTS:
        record(f"verify_{subject}", COLUMNS, (cells(row) for _, rows in verify([subject]) for row in rows))
    return 0
