"""How estimators err once the simulation's noise is taken off, and whether errors hold."""
