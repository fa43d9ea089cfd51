"""Kernels of the drop simulation: exact events, no time step to choose.

Lengths are in radii, time in sqrt(radius / g), mass 1; all vectors in the principal
axes of inertia. The state of a drop is eight numbers (see `layout`).
"""
