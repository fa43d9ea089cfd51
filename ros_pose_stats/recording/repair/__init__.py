"""Bags of runs that ended badly are mended, and the oldest make room."""
