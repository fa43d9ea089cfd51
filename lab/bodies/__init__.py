"""Bodies of the lab, the study and the tests, each made from its arguments alone."""
