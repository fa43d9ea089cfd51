"""Bags: one directory a run, written so that nothing acknowledged is lost, mended and read."""
