"""`python -m lab.benchmarks.exports [--drops N] [--write]`."""

from .measure import main

main()
