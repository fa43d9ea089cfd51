"""Areas of a growing component at many levels, without evaluating each bend at each level.

A component that swallows small neighbours one by one is measured at every one of these
joins. Its area is a sum over its triangles, and the only costly term, the bend of
`right_triangles`, is an analytic function of the level away from its critical value q, where it
starts like |E - q|^(3/2). Hence a tree over the sorted levels: a bend is added to the
largest ranges of levels that lie at least their own width away from q, as its values at
Chebyshev points (order 16, error below 1e-13 of the bend); only next to q it is evaluated
level by level. n joins over n faces cost n log n instead of n².
"""

import math
from typing import Final, NamedTuple

import numpy as np

from ..array_types import Array, Index
from ..body.convex_body import BodyArrays
from ..compilation import inlined, kernel
from .merge_tree import MergeTree, faces_of
from .right_triangles import RightTriangles, bend_R, bend_r

ORDER = 16
FLAT = 1e-12

# columns of the stack (k, 3): number of a tree node and the range of levels that it covers
NODE: Final = 0
LOW: Final = 1
HIGH: Final = 2
STACK: Final = 128
"""Rows: the tree is no deeper."""


class LevelSums(NamedTuple):
    """What grows at the levels of n joins.

    The area is constant + slope * (1/M - 1/E for r, E - M for R) + bends; the first two change
    only where a triangle changes stage, so their steps are kept and summed up at the end. A level
    M amid the path keeps both small.
    """

    levels: Array    # (n,) rising
    middle: float    # M
    constant: Array  # (n + 1,) its steps
    slope: Array     # (n + 1,) its steps
    sums: Array      # (n,) bends that are evaluated level by level
    samples: Array   # (nodes, ORDER) bends at the Chebyshev points of each tree node
    points: Array    # (ORDER,) Chebyshev points
    weights: Array   # (ORDER,) their barycentric weights
    stack: Index     # (STACK, 3) scratch


class Bend(NamedTuple):
    """Where a circle crosses the leg opposite to its centre; see `right_triangles`."""

    leg: float
    centre: float  # distance of the circle's centre: d for r, v for R
    q: float
    about_v: bool  # for R


@kernel
def grown_areas(body: BodyArrays, triangles: RightTriangles, tree: MergeTree, larger: Index,
                path: Index, of_R: bool) -> Array:
    """Area (n,) of the growing component at every join of a path.

    `larger` (S - 1,): which child of each join has more faces; `path` (n,): joins along the larger
    children, by rising level.
    """
    count = path.shape[0]
    into = _nothing_yet(tree.level[path])
    levels, constant = into.levels, into.constant
    for k in range(count):
        # At join k the component holds what came before: its start, and what joins 0 … k-1
        # brought in.
        begin, end = faces_of(tree, tree.child[path[0], larger[path[0]]])
        if k > 0:
            begin, end = faces_of(tree, tree.child[path[k - 1], 1 - larger[path[k - 1]]])
        for i in range(begin, end):
            f = tree.face_order[i]
            if not triangles.partial[f]:
                filled = max(k, np.searchsorted(levels, triangles.fills[f]))
                constant[filled] += triangles.full[f]
                continue
            for n in range(2 * body.face_start[f], 2 * body.face_start[f + 1]):
                _add_triangle(triangles, n, k, of_R, into)
    _collect(into)
    total = rate = 0.0
    for k in range(count):
        total += constant[k]
        rate += into.slope[k]
        step = levels[k] - into.middle
        into.sums[k] += total + rate * (step if of_R else step / (levels[k] * into.middle))
    return into.sums


@kernel
def _nothing_yet(levels: Array) -> LevelSums:
    count = levels.shape[0]
    points, weights = _chebyshev()
    return LevelSums(levels, levels[count // 2], np.zeros(count + 1), np.zeros(count + 1),
                     np.zeros(count), np.zeros((_tree_nodes(count), ORDER)), points, weights,
                     np.empty((STACK, 3), np.int64))


@kernel
def _add_triangle(triangles: RightTriangles, i: int, first: int, of_R: bool,
                  into: LevelSums) -> None:
    """Add one triangle to the sums from join `first` on, stage by stage; see `right_triangles`."""
    levels, middle, constant, slope = into.levels, into.middle, into.constant, into.slope
    whole, turn, leg = triangles.whole[i], triangles.turn[i], triangles.leg[i]
    d, q, v = triangles.near[i], triangles.foot[i], triangles.far[i]
    enters = max(first, np.searchsorted(levels, d, side="right"))
    done = max(enters, np.searchsorted(levels, triangles.done[i], side="left"))
    sense = math.copysign(1.0, turn)
    constant[done] += triangles.after[i]
    if of_R:
        meets = max(enters, min(done, np.searchsorted(levels, q, side="left")))
        start, rate = whole - turn * ((v - middle) / v), turn / v
        _add_bend(into, enters, meets, -sense, Bend(leg, v, q, True))
    else:
        meets = max(enters, min(done, np.searchsorted(levels, q, side="right")))
        start, rate = turn * ((middle - d) / middle), turn * d
        _add_bend(into, meets, done, sense, Bend(leg, d, q, False))
    constant[enters] += start
    constant[done] -= start
    slope[enters] += rate
    slope[done] -= rate


@kernel
def _tree_nodes(levels: int) -> int:
    """Number of tree nodes (numbered as in a heap) that this many levels may need."""
    count = 2
    while levels > ORDER:
        levels = (levels + 1) // 2
        count *= 2
    return 2 * count


@kernel
def _chebyshev() -> tuple[Array, Array]:
    """Chebyshev points of the first kind on [-1, 1] and their barycentric weights."""
    points, weights = np.empty(ORDER), np.empty(ORDER)
    for i in range(ORDER):
        angle = (2 * i + 1) * math.pi / (2 * ORDER)
        points[i] = math.cos(angle)
        weights[i] = math.sin(angle) if i % 2 == 0 else -math.sin(angle)
    return points, weights


@kernel
def _add_bend(into: LevelSums, begin: int, end: int, weight: float, bend: Bend) -> None:
    """Add `weight` times a bend at the levels `begin` to `end`, which all lie beyond its q."""
    levels, points, samples = into.levels, into.points, into.samples
    sums, stack = into.sums, into.stack
    stack[0, NODE], stack[0, LOW], stack[0, HIGH] = 1, 0, levels.shape[0]
    size = 1
    while size > 0:
        size -= 1
        node, low, high = stack[size, NODE], stack[size, LOW], stack[size, HIGH]
        if high <= begin or end <= low:
            continue
        first, last = levels[low], levels[high - 1]
        width = last - first
        gap = bend.q - last if bend.about_v else first - bend.q
        if begin <= low and high <= end and gap >= width and high - low > ORDER:
            if width <= FLAT * last:
                samples[node, 0] += weight * _value(bend, first)
                continue
            for i in range(ORDER):
                level = 0.5 * (first + last) + 0.5 * width * points[i]
                samples[node, i] += weight * _value(bend, level)
            continue
        if high - low <= ORDER:
            for k in range(max(low, begin), min(high, end)):
                sums[k] += weight * _value(bend, levels[k])
            continue
        size = _push_halves(stack, size, node, low, high)


@inlined
def _push_halves(stack: Index, size: int, node: int, low: int, high: int) -> int:
    """Put both halves of a tree node on the stack; return its new size."""
    middle = (low + high) // 2
    stack[size, NODE], stack[size, LOW], stack[size, HIGH] = 2 * node, low, middle
    size += 1
    stack[size, NODE], stack[size, LOW], stack[size, HIGH] = 2 * node + 1, middle, high
    return size + 1


@kernel
def _value(bend: Bend, level: float) -> float:
    if bend.about_v:
        return bend_R(bend.leg, bend.centre, bend.q, level)
    return bend_r(bend.leg, bend.centre, bend.q, level)


@kernel
def _collect(into: LevelSums) -> None:
    """Add the interpolated samples of every tree node to the sums at its levels."""
    levels, samples, sums, stack = into.levels, into.samples, into.sums, into.stack
    points, weights = into.points, into.weights
    stack[0, NODE], stack[0, LOW], stack[0, HIGH] = 1, 0, levels.shape[0]
    size = 1
    while size > 0:
        size -= 1
        node, low, high = stack[size, NODE], stack[size, LOW], stack[size, HIGH]
        if high - low <= ORDER:
            continue
        first, last = levels[low], levels[high - 1]
        for k in range(low, high):
            if last - first <= FLAT * last:
                sums[k] += samples[node, 0]
            else:
                at = (2.0 * levels[k] - first - last) / (last - first)
                sums[k] += _interpolate(at, points, weights, samples, node)
        size = _push_halves(stack, size, node, low, high)


@kernel
def _interpolate(at: float, points: Array, weights: Array, samples: Array, node: int) -> float:
    """Barycentric interpolation, which is exact at the points."""
    above = below = 0.0
    for i in range(ORDER):
        if at == points[i]:
            return float(samples[node, i])
        part = weights[i] / (at - points[i])
        above += part * samples[node, i]
        below += part
    return above / below
