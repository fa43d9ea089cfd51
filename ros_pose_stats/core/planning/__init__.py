"""Which method answers a request, how sure its answer is, and the plan of a feeder's plate."""
