"""Benchmarks of the numeric core: bodies, timing, rows and the report."""
