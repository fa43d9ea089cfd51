"""The commands about the study: datasets of bodies, and how wrong each method is on them."""
