"""What is measured of a waveform, simulated or filmed: cycles, and quantities with their spread."""
