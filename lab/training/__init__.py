"""Families of bodies, samples of drops, and the fits that give the weights of the
estimators.
"""
