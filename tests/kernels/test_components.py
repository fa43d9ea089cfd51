"""Components by joining sets against scipy's walk through the graph."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

from ros_pose_stats.kernels.mesh.components import component_labels


@given(st.integers(1, 40), st.integers(0, 60), st.integers(0, 2**32 - 1))
def test_labels_count_up_with_the_lowest_nodes(count, links, seed):
    pairs = np.random.default_rng(seed).integers(0, count, (links, 2))
    graph = csr_matrix((np.ones(links), pairs.T), shape=(count, count))
    expected = connected_components(graph, directed=False)[1]
    assert component_labels(count, pairs).tolist() == expected.tolist()


def test_a_long_chain_in_the_worst_order():
    chain = np.arange(20_000)
    pairs = np.stack((chain[1:], chain[:-1]), axis=1)[::-1].copy()
    assert not component_labels(len(chain), pairs).any()
