"""Connected components by joining sets."""

from __future__ import annotations

import numpy as np

from ..array_types import FixedIndex2, Index
from ..compilation import entry_kernel, inlined


@inlined
def root(link: Index, a: int) -> int:
    """Representative of the set of `a`; `link` is shortened on the way."""
    while link[a] != a:
        link[a] = link[link[a]]
        a = link[a]
    return a


@inlined
def join(link: Index, a: int, b: int) -> None:
    """Unite the sets of `a` and `b`; the lowest member represents each set."""
    a, b = root(link, a), root(link, b)
    if a < b:
        link[b] = a
    else:
        link[a] = b


@entry_kernel
def component_labels(count: int, pairs: FixedIndex2) -> Index:
    """Component label of each node.

    `pairs` (k, 2): linked nodes, in any order, repeated or not. Returns (count,): labels 0, 1, ...
    without gaps, in the order of the components' lowest nodes.
    """
    link = np.arange(count)
    for k in range(pairs.shape[0]):
        join(link, pairs[k, 0], pairs[k, 1])
    labels = np.empty(count, np.int64)
    found = 0
    for i in range(count):
        lowest = root(link, i)
        if lowest == i:
            labels[i] = found
            found += 1
        else:
            labels[i] = labels[lowest]
    return labels
