"""Figures, tables and number formats of the reports of runs and recordings."""
