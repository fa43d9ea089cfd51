"""Bags while they are written."""
