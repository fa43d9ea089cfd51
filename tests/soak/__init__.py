"""Studies of hours: drops without end, and a node under faults."""
