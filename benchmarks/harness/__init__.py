"""How benchmarks are run, recorded and shown, whatever their subject."""
