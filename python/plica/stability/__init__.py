"""Vibration of a scene at rest: its modes, small oscillations in its airflow, and the onset of phonation."""
