"""The demo parts, and the outlines that they are made of."""
