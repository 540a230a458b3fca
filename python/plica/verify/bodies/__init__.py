"""Bodies whose motion is known: what cases of verification and benchmarks compute."""
