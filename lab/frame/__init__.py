"""How programs of the lab and the study measure, store and render."""
