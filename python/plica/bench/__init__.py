"""Benchmarks that come with the package: ``plica bench``. Nothing else in the package imports them."""
