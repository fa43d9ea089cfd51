"""`python -m benchmarks.exports [--drops N] [--write]`."""

from .measure import main

main()
