"""Fits the split estimator to drop simulations of many families of bodies, and judges it."""
