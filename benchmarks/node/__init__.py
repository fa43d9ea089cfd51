"""The node over DDS: `python -m benchmarks.node [--quick] [--write]`."""
