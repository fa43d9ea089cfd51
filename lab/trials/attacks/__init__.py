"""What careless and hostile neighbours do to a node: `python -m lab.trials.attacks`."""
