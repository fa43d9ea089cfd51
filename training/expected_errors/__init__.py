"""Fit of the expected errors of the estimators, and how they come true."""
