"""Tissue motion from frames."""
