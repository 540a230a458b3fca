"""Simulation of phonation: scenes, runs and their storage, measures and reports."""
