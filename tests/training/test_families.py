"""Bodies of every family: the same ones again, rigid bodies, and what the family promises."""

from __future__ import annotations

import numpy as np
import pytest

from ros_pose_stats.shapes import hull_mesh
from training.families import FAMILIES, family_part, family_poses
from training.families.solids import assembled, block, extruded, fan


@pytest.mark.parametrize("family", FAMILIES)
def test_bodies(family):
    for number in (0, 7):
        part = family_part(family, 5, number)
        assert part.digest == family_part(family, 5, number).digest
        resting = family_poses(family, part)
        assert len(resting.poses) > 1
        assert resting.body.arrays.distance.min() > 0.0  # the centre of mass lies inside
        low, middle, high = np.linalg.eigvalsh(resting.inertia)
        assert low > 0.0 and high <= low + middle
    assert part.digest != family_part(family, 5, 0).digest
    assert part.digest != family_part(family, 6, 7).digest


def some(family, count=12):
    return [family_part(family, 5, number) for number in range(count)]


def extents(part):
    """Along the principal axes, rising."""
    axes = np.linalg.eigh(part.inertia)[1]
    return np.sort(np.ptp((part.vertices - part.center_of_mass) @ axes, axis=0))


def test_fine_families_have_many_corners():
    def corners(family):
        return [len(family_poses(family, part).body.points) for part in some(family)]

    assert min(corners("fine ellipsoids")) >= 90
    assert max(corners("lumps")) > 200 and max(corners("ellipsoids")) <= 60


@pytest.mark.parametrize("family", ["rounds", "hollow"])
def test_turned_parts_are_round(family):
    """Two of their principal moments are the same."""
    for part in some(family, 6):
        assert min(np.diff(np.linalg.eigvalsh(family_poses(family, part).inertia))) < 1e-9


def test_slender_families():
    assert all(extents(part)[2] > 2.0 * extents(part)[1] for part in some("bars"))
    assert np.median([extents(part)[0] / extents(part)[2] for part in some("sheets")]) < 0.3
    for part in some("near-cubes"):
        low, _, high = extents(part)
        assert 1.0 < high / low < 1.9  # corner to corner at most


def test_gears_have_gaps():
    for part in some("gears", 6):
        whole = np.abs(np.linalg.det(part.vertices[part.triangles])).sum()
        vertices, triangles = hull_mesh(part.vertices)
        assert len(vertices) < len(part.vertices)
        assert np.abs(np.linalg.det(vertices[triangles])).sum() > 0.0 < whole


def test_assembled_solids_have_the_mass_properties_of_the_whole():
    """A box with a square hole, by the formulas for boxes; whether convex or by its triangles."""
    outline = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
    hole = extruded(0.5 * outline, 0.0, 1.0).hole()
    mass = 4.0 - 1.0
    about_z = (4.0 * (4.0 + 4.0) - 1.0 * (1.0 + 1.0)) / 12.0
    size = 1.5  # half the diagonal of the box
    for solid in (block((-1.0, -1.0, 0.0), (1.0, 1.0, 1.0)), fan(outline, 0.0, 1.0)):
        part = assembled([solid, hole])
        assert part.inertia[2, 2] == pytest.approx(about_z / (mass * size * size))
        assert np.ptp(part.vertices, axis=0) == pytest.approx(np.array([2.0, 2.0, 1.0]) / size)


def test_milled_parts_have_arcs_that_are_no_circles():
    """Most have many more corners than poses; few are round."""
    parts = some("milled")
    poses = [family_poses("milled", part) for part in parts]
    assert np.median([len(one.body.points) / len(one.poses) for one in poses]) > 5.0
    assert sum(one.poses[0].yaw_symmetry == 0 for one in poses) == 0
