"""The rows of `plica verify`, a record of each subject, for docs/verify.md.

python -m benchmarks.verification
"""

from __future__ import annotations

import argparse

from benchmarks.record import cells, record
from plica.report.installation import this_installation
from plica.verify.subjects import SUBJECTS, verify
from plica.verify.text import as_markdown

if __name__ == "__main__":
    argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    ).parse_args()
    for subject in SUBJECTS:
        page = as_markdown(list(verify([subject])), this_installation())
        columns, *rows = cells(page.splitlines())
        record(f"verify_{subject}", columns, rows, command=f"plica verify --subject {subject} -o DIR")
