"""Command line of the benchmark of the drop simulation."""

from .measure import main

main()
