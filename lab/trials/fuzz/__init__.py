"""Inputs that are not quite right: `python -m lab.trials.fuzz`."""
