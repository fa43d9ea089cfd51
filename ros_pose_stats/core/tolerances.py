# Copyright 2026 ros_pose_stats authors
#
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this
# file except in compliance with the License. You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software distributed under
# the License is distributed on an "AS IS" BASIS, WITHOUT WARRANTIES OR CONDITIONS OF
# ANY KIND, either express or implied. See the License for the specific language
# governing permissions and limitations under the License.

"""Every tolerance of the numeric core, each with its reason.

Unless said otherwise a tolerance is relative to the part's radius (the largest distance
from the centre of mass to a vertex), so that no answer depends on units.
"""

from collections.abc import Sequence

WELD = 1e-8
"""Vertices closer than this, as a fraction of the largest extent, are one vertex.

Files repeat a vertex for each triangle, at times with a last digit of difference;
float32 rounds at 6e-8, but a file rounds equal numbers alike, so nothing wider is
needed.
"""

FLATTEST = 1e-7
"""Smallest extent of an acceptable point set, as a fraction of the largest.

A needle of 1 : 1e-4 is a part; below 1e-7 float32 coordinates are pure noise.
"""

HOLLOW = 1e-9
"""Smallest enclosed volume, as a fraction of the hull's, that counts as a solid."""

TRIANGLE_INEQUALITY = 1e-6
"""Relative slack when checking that principal moments satisfy I1 + I2 >= I3.

A flat plate meets it with equality and CAD systems print six or seven digits.
"""

OVERLAP = 1e-5
"""Bodies that overlap by less than this fraction of the size only touch."""

ON_HULL = 1e-12
"""A centre of mass this close to a face of the hull (in radii) counts as on it.

Below it the sign of the distance is decided by rounding.
"""

SHAKEN = (1e-12, 1e-11)
"""Fractions of the size by which points move where a face of the hull is crowded.

A hundred times more than what Qhull takes for coplanar. It decides how flat faces are
cut, and whether a point that close to a face is a corner of it; no coordinate changes.
The second is tried where Qhull gives up on the first.
"""

COPLANAR = 1e-6
"""Hull triangles whose vertices lie this close to one plane form one face.

STL stores float32: a coordinate is off by up to 6e-8 of its size, a plane through a few
such points by some 3e-7. Facets of a tessellated curve bulge by 1e-4 or more.
"""

COPLANAR_OF_THICKNESS = 1e-3
"""Bound of COPLANAR in smallest extents: thin plates keep two sides."""

COPLANAR_ROUNDINGS = 8.0
"""Hull triangles also form one face within so many roundings of coordinates.

A part in float32 ten sizes off its origin has its corners off by 6e-7 of its size.
"""

COPLANAR_MOST = 1e-4
"""But never wider than this: beyond it facets of a tessellated curve would merge."""

TIP_MARGIN = 1e-9
"""A face is stable with the foot of the centre of mass this deep in its polygon.

Between -1e-9 and 1e-9 rounding after a rotation would decide; the pose is then not
listed. Its probability by EAE and MEAE would be zero to that order anyway.
"""

SAME_POINT = 1e-9
"""Corners of an outline this close are one, or none this close to a line."""

SAME_LEVEL = 1e-10
"""Saddles this close in level tie: on a symmetric part only rounding parts them."""

SAME_EDGE = 1e-5
"""A toppling direction this close to a corner is shared by the two sides there.

On a symmetric part float32 noise would otherwise choose one of them; it moves the foot
of the centre of mass on a small face by some 1e-6.
"""

SAME_HEIGHT = 1e-6
"""Heights this close are a tie in the numbering of poses; float32 noise is below it."""

SAME_DOWN = 1e-5
"""Components of `down` this close are a tie in the numbering of poses (radians)."""

SYMMETRY = 1e-5
"""A rotation is a symmetry when every feature lands this close to its image.

A smaller asymmetry cannot be told from float32 noise of a part some way off its origin,
and changes probabilities by no more than its own order.
"""

TOUCHING = 1e-9
"""A vertex this close to the plate takes part in what happens there (appendix B)."""

SLOW = 1e-5
"""An infinite series of impacts is cut off when no touching vertex approaches faster.

In units of sqrt(g radius), as in appendix B.
"""

SOON_OVER = 5e-4
"""Or when none approaches faster than this times 1 - restitution, if that is more.

The energy that is dropped is within `SOFT` and `SOFT_SHARE`: what is left of the series
then takes some 1e-3 sqrt(radius / g), and leaves a part that turns slowly where the cut
leaves it.
"""

SOFT = 1e-9
"""Most energy, in m g radius, that bringing one slow vertex to rest may cost.

Two corners 1e-6 apart on a body that turns are both slow, but stopping both would stop
the turn; the second one goes on to bounce instead.
"""

SOFT_SHARE = 1e-4
"""The same as a share of the kinetic energy: of a roll on facets what bounces."""

AT_REST = 1e-13
"""A vertex that approaches more slowly is at rest; rounding stays below this."""

TRUNCATION = 1e-12
"""Terms of a power series of the motion below this are left out; a hundred steps then
add up to a tenth of `TOUCHING`.
"""

DEPENDENT = 1e-9
"""A contact adds nothing to those before it when only this share of it is new."""

PULL = 1e-12
"""Contact forces, in weights, count as zero down to this below it."""

SINKING = 1e-9
"""Downward acceleration, in g, of a vertex beside the contact that is rounding."""

JUST_TOUCHING = 1e-13
"""A vertex just hit or released that is no higher starts its way up from exactly 0."""

TRAP = 1e-9
"""A drop is decided with its energy this far (in m g radius) below the saddle out."""

MOST_STEPS = 100_000
"""Impacts and steps, some 40 to 200 ms, in which a drop must make `PROGRESS`.

Else it is given up. A body balanced on an unstable equilibrium makes none, nor do
restitutions above 0.999 (of a needle 0.99), and bodies with almost no inertia about an
axis that corners are far from.
"""

PROGRESS = 0.05
"""Share of the energy above the pose below that a drop must lose in so many steps.

Steps of a part that rolls grow with the square of its sides, and with the slenderness
of the rim, so that no number of steps is right for all; the slowest ones seen lose a
fifth each time.
"""

LONG_DROP = 100
"""Impacts and steps of a drop, from which on one of equal poses is drawn.

Most drops have ended by then, on the pose that a recording shows.
"""

MOST_GRANTS = 12
"""Times that so many steps are granted: more than any rolling part took.

Released 1e160 m above the plate a drop loses a twentieth for hours, and nobody can stop
it.
"""

MARGINAL_TILT = 0.0175
"""Tilt of one degree: a pose that it topples is marginal, as plates are set up."""

SHALLOW_BARRIER = 0.05
"""A barrier below this fraction of the part's highest is small beside the others."""

NEAR_TIE = 1e-3
"""Saddles closer in height than this, in radii, tie for practical purposes."""

EXACT_TIE = 1e-5
"""Saddles closer than this tie by symmetry; float32 files round at some 1e-7."""

CURVED = 0.27
"""Angle between facets, radians, that may be those of a curve; a 24-gon has 0.262."""

BENT = 0.6
"""Angle between faces, radians, above which an edge is one that was designed."""

NARROW = 3.0
"""Turns that a facet of a curve is wide at most, seen from the centre of mass."""

ON_RUN = 1e-3
"""A corner this close to a circle of the body is one of its run."""

FEWEST_FACETS = 8
"""Facets that are taken for a curve."""

EXPORTS_DIFFER = 10
"""Points by which shares change with each halving of a curve's facets: no circle."""

SAME_SHARE = 1e-10
"""Probabilities this close are a tie: on a symmetric part only rounding parts them."""


def number_equal(values: Sequence[float], tolerance: float) -> list[int]:
    """Number values by rising size; those equal but for rounding have one number.

    A tie begins at its smallest value and holds all within the tolerance of that one,
    so that equal values never fall apart at a decimal, as they do when they are rounded
    to it.
    """
    numbers = [0] * len(values)
    number = -1
    tie_begin = -float("inf")
    for index in sorted(range(len(values)), key=values.__getitem__):
        if values[index] > tie_begin + tolerance:
            number = number + 1
            tie_begin = values[index]
        numbers[index] = number
    return numbers
