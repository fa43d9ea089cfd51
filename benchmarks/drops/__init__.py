"""Speed and soundness of the drop simulation: `python -m benchmarks.drops [--quick] [--write]`."""
