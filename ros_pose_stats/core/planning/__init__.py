"""Which method answers a request, how sure it is, and the plan of a feeder."""
