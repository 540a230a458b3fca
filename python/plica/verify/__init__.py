"""Cases whose results are known exactly."""
