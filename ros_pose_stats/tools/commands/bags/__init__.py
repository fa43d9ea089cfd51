"""The command `bag`: reports and tables of recorded runs."""
