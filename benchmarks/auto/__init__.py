"""Benchmark of estimates combined with drops, and of the choice of method for a target."""
