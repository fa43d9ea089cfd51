"""The node over DDS: `python -m lab.benchmarks.node [--quick] [--write]`."""
