"""Filter, smoother and EM of linear Gaussian models."""
