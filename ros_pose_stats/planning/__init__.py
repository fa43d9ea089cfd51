"""Which method answers a request: an estimate, drops, or both combined."""
