"""A part that the estimate is wrong about, in a node that drops it in the background."""

from __future__ import annotations

from geometry_msgs.msg import Inertia, Vector3

from ros_pose_stats import hybrid, simulate
from ros_pose_stats.recording.conflicts import FOLDER, read_conflicts
from training.families import family_part

from .harness.cell import cell_of, latched
from .harness.client import until
from .harness.parts import flat, probabilities

ODD = ("polyhedra 0.65 second", 4242, 5036)
"""One of several hundred random polyhedra: a pose is far more probable than estimated."""

SCENE = {"restitution": 0.2}


def inertia_of(part):
    """Mass properties as a message."""
    x, y, z = part.inertia.tolist()
    return Inertia(m=part.mass, com=Vector3(**dict(zip("xyz", part.center_of_mass.tolist(),
                                                       strict=True))),
                   ixx=x[0], ixy=x[1], ixz=x[2], iyy=y[1], iyz=y[2], izz=z[2])


def test_drops_win_and_the_case_is_kept(domain, tmp_path):
    part = family_part(*ODD)
    told = hybrid(part, 5000, seed=1, **SCENE).warnings
    assert any(line.startswith("CONFLICT:") for line in told), "another body is needed: ODD"
    with cell_of(domain, tmp_path, "doubting", refine_drops=5000, **SCENE) as (node, client):
        surface = part.vertices, part.triangles
        client.good("estimate", part=flat(surface, "odd", inertia=inertia_of(part)))

        def contradicted():
            found = latched(client, "odd")
            return found if found.final and found.drops == 5000 else None
        found = until(contradicted, "the drops")
        assert any(line.startswith("CONFLICT:") for line in found.warnings)
        counted = simulate(part, 5000, seed=found.seed, **SCENE)
        assert probabilities(found.poses) == {
            pose.index: pose.probability for pose in counted.poses}
        [kept] = until(lambda: list(read_conflicts(tmp_path / FOLDER)), "the kept case")
        assert kept.part.digest == part.digest and kept.seed == found.seed
        node.assert_sound()
