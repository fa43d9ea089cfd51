"""From mesh files to convex bodies, equilibria, poses and their splitting graph."""
