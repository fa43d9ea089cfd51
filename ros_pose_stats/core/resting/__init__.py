"""From a part to its equilibria, poses, symmetry and splitting graph."""
