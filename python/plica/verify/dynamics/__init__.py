"""Motion in time: schemes, energy and momentum, and results that are the same to the bit."""
