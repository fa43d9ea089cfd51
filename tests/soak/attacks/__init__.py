"""Attacks on the node: what a careless or hostile neighbour does to it, in miniature."""
