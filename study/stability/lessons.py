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

"""What each walk of the stability study teaches, in words."""

from typing import Final

LESSONS: Final = {
    "marginal_face": (
        "A face that is about to stop being stable still gets its full share from the "
        "area, the centroid solid angle and what is built on them, up to the moment "
        "when it gets nothing. EAE and MEAE fade it out, and so do drops. The warning "
        "MARGINAL_POSE says when a part is here: the real part, off by a tenth of a "
        "millimetre, may be on either side."
    ),
    "coplanar_faces": (
        "Two faces that are nearly one change nothing for drops. Estimators share out "
        "the same total between them, but for PQSE and NQSE, which do not add up over "
        "faces, and the combined estimator, which has NQSE in it: they change where "
        "the faces merge. Cluster tolerance 0 shows it; at the default the two are one "
        "pose long before."
    ),
    "cylinder_sides": (
        "From fifteen sides on a run of facets is a round surface, which stands as 192 "
        "sides a turn however the file cuts it: the same answers from 15 to 512 sides, "
        "drops included. With fewer sides the file means a polygon, and gets one: such "
        "a prism stops rolling sooner. Before runs were found, drops went from one end "
        "of this figure to the other."
    ),
    "gear_teeth": (
        "Teeth are not filled: a run of gaps stays as the file has it, since a gear "
        "does not roll as its outer circle does. From fifteen teeth on they are one "
        "pose, the rim; with fewer every tooth is a pose. Coarse teeth stop the "
        "rolling soon and leave the gear on its rim, fine ones let it roll on until it "
        "falls flat: of the paper's estimators none knows that, `split` does. PQSE and "
        "NQSE leap where the teeth become one pose."
    ),
    "hole_size": (
        "A hole changes nothing of the hull; it moves the centre of mass and the "
        "inertia. A blind one of half the width moves the centre of this block by a "
        "hundredth of its height, and nothing happens; one of nine tenths makes a cup, "
        "which comes to rest on its closed end more often, though less so than EAE "
        "tells. A mesh without its holes answers for the left end of this figure."
    ),
    "nudge": (
        "The larger the nudge, the fewer the poses: a shallow one is told with the "
        "pose that the part slips into. Drops seldom end in a shallow one, so that it "
        "hardly matters to them, nor to the estimators that walk down the splitting "
        "graph. Those that go by faces give each its full share, and so nearly nothing "
        "to the pose that most drops end in, until the others are poured into it."
    ),
    "heavy_sphere": (
        "With hundreds of shallow poses the older estimators do not see that the heavy "
        "side pulls: most facets stay stable, so most share in the probability. Drops "
        "roll to the heavy side once the offset beats the facets. EAE, MEAE and "
        "`split` follow in kind, not in number. "
        "Expect little of any estimator for a part that is nearly a ball, and simulate."
    ),
    "needle": (
        "All methods agree on plates and needles, and on the cube by symmetry. In "
        "between they part company, most at thick plates and short bars, which many "
        "parts are: see the dice in accuracy.md."
    ),
    "broken_symmetry": (
        "A cube whose corners are off by a millionth has faces of two triangles each, "
        "and one triangle of a face may hold the foot of the centre of mass alone. "
        "Estimators that add up faces count the stable triangle only, and PQSE leaps "
        "with the areas of the two. QSE lets the other one topple onto it, EAE, MEAE "
        "and `split` see one valley: these hardly move. Drops do not move as long as "
        "the cube is nearly one."
    ),
    "vertex_noise": (
        "Noise of the vertices up to a thousandth of the radius changes no method; at "
        "a hundredth faces begin to appear and vanish, and estimators that jump there "
        "jump."
    ),
    "restitution": (
        "None of the paper's estimators knows the plate. The simulation's probability "
        "changes by far more than its noise between soft and hard plates, and not "
        "steadily: no single estimate is right for all of them. `split` knows the "
        "restitution and goes with the drops, but for the ups and downs on soft "
        "plates: give it, and simulate if they matter."
    ),
    "rocking": (
        "Two neighbouring faces, a ridge of less than a hundred-thousandth of the "
        "radius between the higher one and the lower. Whether the part rocks itself to "
        "rest on the higher face or over the ridge is decided by a few impacts, and "
        "changes within a few hundredths of the restitution. No estimator that is "
        "smooth in the scene and in the shape follows that; the largest deviations of "
        "all methods are of this kind. At cluster tolerance 0, as here, MARGINAL_POSE "
        "and SHALLOW_POSE warn of it; at the default the two are one pose. Where it "
        "matters, simulate with the restitution of the real ground."
    ),
    "drop_height": (
        "Released touching or nearly so, the part stays where it is put: the "
        "simulation then follows the starting poses. Above a few radii the height "
        "hardly matters, and the paper's estimators are made for that. Feeder lips are "
        "one to three radii high, where LOW_DROP warns of them. `split` knows the "
        "height from touching up, but smooths over what happens below three radii, and "
        "says so in its error: simulate with the real height, or let `hybrid` add "
        "drops."
    ),
}
"""By the walk's name."""
