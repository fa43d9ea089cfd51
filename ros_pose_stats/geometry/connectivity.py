"""Connected components of a graph given as pairs of node numbers."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components


def components(count: int, pairs: NDArray[np.int64]) -> NDArray[np.int64]:
    """Component label of each node.

    Parameters
    ----------
    count : int
        Number of nodes.
    pairs : (k, 2) array
        Linked nodes, in any order, repeated or not.

    Returns
    -------
    (count,) array
        Labels 0, 1, ... without gaps.
    """
    links = np.ones(len(pairs), dtype=np.int32)
    graph = csr_matrix((links, (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    labels: NDArray[np.int64] = connected_components(graph, directed=False)[1].astype(np.int64)
    return labels
