"""Benchmark of estimates combined with drops, and of `auto`, which chooses a method."""
