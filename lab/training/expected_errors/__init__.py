"""Fit of the expected errors of the estimators, and their comparison with true
errors.
"""
