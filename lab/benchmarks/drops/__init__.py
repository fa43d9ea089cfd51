"""Speed and soundness of drops: `python -m lab.benchmarks.drops [--quick]
[--write]`.
"""
