"""Errors of estimators without the simulation's noise, and tests of standard errors."""
