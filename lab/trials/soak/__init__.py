"""Loads that last: `python -m lab.trials.soak`."""
