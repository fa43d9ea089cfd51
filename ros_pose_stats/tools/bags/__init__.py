"""Bags read and analysed, whoever recorded them."""
