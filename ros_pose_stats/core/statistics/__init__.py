"""How sure counted drops are: intervals, standard errors, when to stop, tests."""
