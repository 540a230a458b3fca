"""Measures of simulated or recorded waveforms: cycles, and quantities with their spread."""
