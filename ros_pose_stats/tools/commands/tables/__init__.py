"""Recorded runs in tables: a report for people, and CSV files."""
