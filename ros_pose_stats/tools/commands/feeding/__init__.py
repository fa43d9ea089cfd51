"""Commands about a plate and what a feeder does on it: `fit`, `flips` and `feeding`."""
