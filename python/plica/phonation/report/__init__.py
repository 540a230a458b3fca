"""The report of a run: one self-contained page."""

from plica.phonation.report.page import write_report

__all__ = ["write_report"]
