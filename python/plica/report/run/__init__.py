"""The report of a run: one self-contained page."""

from plica.report.run.page import write_report

__all__ = ["write_report"]
