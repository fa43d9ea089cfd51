"""The commands of the study: datasets of bodies, and the errors of each method on them."""
