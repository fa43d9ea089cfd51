"""Bags: one directory a run, a log that is written, mended, read and analysed."""
