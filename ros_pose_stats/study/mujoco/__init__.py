"""MuJoCo as a contender in dropping a part, where it is installed.

MuJoCo needs a time step and gets restitution from a soft contact, whose depth takes the
place of a tolerance: `contact` sets it up and finds a time step for it, `plate` is the scene,
`dropping` the drops. Lengths are in radii, time in sqrt(radius / g), mass 1.
"""
