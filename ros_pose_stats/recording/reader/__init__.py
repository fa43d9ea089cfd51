"""Bags read back, whoever wrote them and however they ended."""
