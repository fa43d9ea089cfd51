"""Command line of the benchmark of hybrid and auto."""

from .measure import main

main()
