"""Families of bodies, samples and fits: where the weights of the estimators come from."""
