"""Grouped edges and neighbours against dictionaries."""

from __future__ import annotations

from collections import defaultdict

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from ros_pose_stats.kernels.mesh.edges import FEW, grouped_edges, linked_triangles, neighbours


def by_edge(triangles):
    """Directed edges (triangle, place in it, forward) of each undirected edge."""
    found = defaultdict(list)
    for t, corners in enumerate(triangles.tolist()):
        for i in range(3):
            a, b = corners[i], corners[(i + 1) % 3]
            found[min(a, b), max(a, b)].append((t, i, a < b))
    return dict(sorted(found.items()))


def check(triangles):
    triangle, forward, start, uses = grouped_edges(triangles)
    expected = by_edge(triangles)
    assert uses.tolist() == [len(edges) for edges in expected.values()]
    assert start.tolist() == np.cumsum([0, *uses])[:-1].tolist()
    flat = [edge for edges in expected.values() for edge in edges]
    assert triangle.tolist() == [t for t, _, _ in flat]
    assert forward.tolist() == [ahead for _, _, ahead in flat]
    pairs = [edges for edges in expected.values() if len(edges) == 2]
    linked, agree = linked_triangles(triangle, forward, start, uses)
    assert linked.tolist() == [[a[0], b[0]] for a, b in pairs]
    assert agree.tolist() == [a[2] != b[2] for a, b in pairs]
    across = np.full(triangles.shape, -1)
    for (t, i, _), (other, j, _) in pairs:
        across[t, (i + 2) % 3], across[other, (j + 2) % 3] = other, t
    assert neighbours(triangles).tolist() == across.tolist()


@pytest.mark.long
@given(st.integers(3, 12), st.integers(1, 30), st.integers(0, 2**32 - 1))
def test_any_triangles(vertices, count, seed):
    random = np.random.default_rng(seed)
    check(np.array([random.permutation(vertices)[:3] for _ in range(count)]))


@pytest.mark.parametrize("apex", [0, FEW * 2])
def test_a_fan_around_one_vertex(apex):
    # The apex has more edges than are sorted one by one, whether it comes first or last.
    mesh = trimesh.creation.cone(1.0, 1.0, sections=3 * FEW)
    triangles = np.asarray(mesh.faces)
    check((triangles + apex) % len(mesh.vertices))


def test_no_triangles():
    assert all(len(array) == 0 for array in grouped_edges(np.zeros((0, 3), dtype=np.int64)))
