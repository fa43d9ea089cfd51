"""What `make demo` runs: a cell of a node, a planner and a camera, end to end."""
