"""The report of a run: one page that needs nothing else."""

from plica.phonation.report.page import write_report

__all__ = ["write_report"]
