"""Programs of a checkout that are not installed: training, benchmarks, trials, the
demo.
"""
