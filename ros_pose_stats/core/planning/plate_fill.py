"""Room on a plate for parts that lie anywhere, as far as they do not block each other."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ..records import Array, Index, Mask, Part, StablePose
from ..resting.outlines import area_and_length, outline_at

PLACES = 6
DIRECTIONS = 96
"""Nodes along half a side of the plate, and directions in which its edge is looked for."""

GOLDEN = 0.5 * (5.0**0.5 - 1.0)  # turns by it are spread evenly
NODES = 97
TURNS = 32
"""Nodes along a side of the raster on which true silhouettes meet, and ways in which another part
lies: enough for the fill of real outlines to a percent or two (docs/measured/benchmarks.md)."""

MOST_OUTLINED = (
    16  # kinds of picked poses, the likeliest; others are taken for their mean
)


class PlateFill(NamedTuple):
    """Room on a plate for parts that lie in given shares in their poses."""

    # (K, Q); where another part's centre blocks a part in each pose at each node, over the plate
    blocked: Array
    weight: Array  # (Q,); of the nodes, 1 in all

    def free(self, parts: Index) -> Array:
        """Probabilities (N, K) that none of the others blocks a part, by the parts (N,)."""
        others = parts[:, None, None] - 1.0
        return np.asarray((1.0 - self.blocked) ** others @ self.weight)


def plate_fill(
    outlines: Sequence[Array],
    shares: Array,
    plate: tuple[float, float],
    clearance: float,
    blocking: Array | float = 1.0,
) -> PlateFill:
    """Room on a plate, `plate` metres, over which the parts' centres spread evenly.

    Parts lie anywhere and turned anyhow, each by itself, as in D. Gudmundsson and K. Goldberg,
    "Tuning robotic part feeder parameters to maximize throughput" (ICRA 1997).
    `outlines`: convex silhouettes (k, 2) of the poses (K,), metres; `shares` (K,): of the parts
    that lie in each. A part is blocked where another one is nearer than the clearance. Over their
    turns, centres that are too near have the mean area A_i + A_j + L_i L_j / 2 pi of outlines
    of area A and length L, one of them grown by the clearance; of that the share `blocking` (K,)
    is taken as a disc and cut off at the edges of the plate.
    """
    area, length = np.array([area_and_length(outline) for outline in outlines]).T
    near = area + clearance * length + np.pi * clearance * clearance
    around = (length + 2.0 * np.pi * clearance) / (2.0 * np.pi)
    disc = (
        blocking * (near + shares @ area + around * (shares @ length)) / np.pi
    )  # squared radii

    node, weight = np.polynomial.legendre.leggauss(PLACES)
    place = np.stack(
        np.meshgrid(*((1.0 + node) * 0.25 * side for side in plate)), axis=-1
    )
    angle = (np.arange(DIRECTIONS) + 0.5) * (2.0 * np.pi / DIRECTIONS)
    course = np.stack((np.cos(angle), np.sin(angle)), axis=-1)
    room = np.where(
        course > 0.0,
        np.asarray(plate) - place.reshape(-1, 1, 2),
        place.reshape(-1, 1, 2),
    )
    edge = (room / np.abs(course)).min(axis=-1) ** 2
    inside = np.pi * np.minimum(disc[:, None, None], edge).mean(axis=-1)
    blocked: Array = np.minimum(1.0, inside / (plate[0] * plate[1]))
    return PlateFill(
        blocked, np.asarray(0.25 * np.outer(weight, weight).ravel(), np.float64)
    )


def blocking_with_bays(
    part: Part,
    poses: Sequence[StablePose],
    shares: Array,
    picked: Index,
    clearance: float,
) -> Array:
    """Share (K,) of the area in which convex silhouettes block a part that its own ones leave.

    Of the poses `picked`; of the others it is 1. The other part lies in its poses by their shares,
    and turned evenly; areas are counted on a raster, on which both kinds err alike.
    """
    from scipy import ndimage, signal  # slow to load, and only bays need them

    _, first, group = np.unique(
        [pose.group for pose in poses], return_index=True, return_inverse=True
    )
    ways = shares.sum() * (np.arange(TURNS) + 0.5) / TURNS
    other = np.searchsorted(shares.cumsum(), ways).clip(max=len(poses) - 1)
    # Of poses that look alike the first stands for all.
    mine = first[group[picked]]
    other = first[group[other]]
    kinds = sorted(set(mine.tolist()), key=lambda index: -shares[index])[:MOST_OUTLINED]
    hulls = {index: [poses[index].outline] for index in {*kinds, *other.tolist()}}
    # What has no width has no outline of its own.
    outlines = {
        index: [ring for polygon in outline_at(part, poses[index]) for ring in polygon]
        or hull
        for index, hull in hulls.items()
    }
    reach = clearance + max(np.hypot(*pose.outline.T).max() for pose in poses)
    # No node lies on the axes, to which parts are symmetric.
    node = (np.arange(NODES) - 0.5 * NODES + GOLDEN) * (2.0 * reach / (NODES - 1))

    def blocked(silhouettes: Mapping[int, Sequence[Array]]) -> Array:
        """Nodes (kinds,) at which a centre of another part is too near, in all turns."""
        others = [
            _covered(silhouettes[index], turn, node)[::-1, ::-1].astype(float)
            for index, turn in zip(
                other, 2.0 * np.pi * GOLDEN * np.arange(TURNS), strict=True
            )
        ]
        grown = [
            ndimage.distance_transform_edt(
                ~_covered(silhouettes[index], 0.0, node), sampling=node[1] - node[0]
            )
            <= clearance
            for index in kinds
        ]
        return np.array(
            [
                sum(
                    np.count_nonzero(signal.fftconvolve(one, each) > 0.5)
                    for each in others
                )
                for one in grown
            ],
            dtype=np.float64,
        )

    share = blocked(outlines) / blocked(hulls)
    of_kind = dict(zip(kinds, share.tolist(), strict=True))
    found = np.ones(len(poses))
    found[picked] = [of_kind.get(index, share.mean()) for index in mine.tolist()]
    return found


def _covered(rings: Sequence[Array], turn: float, node: Array) -> Mask:
    """Nodes (y, x) of a raster that rings (k, 2), once they are turned, enclose or come near."""
    turned = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    rings = [ring @ turned for ring in rings]
    begin = np.concatenate(rings)
    end = np.concatenate([np.roll(ring, -1, axis=0) for ring in rings])
    row, edge = np.nonzero((begin[:, 1] > node[:, None]) != (end[:, 1] > node[:, None]))
    (x, y), (across, up) = begin[edge].T, (end - begin)[edge].T
    crossed = np.zeros((node.size, node.size + 1), dtype=np.int64)
    np.add.at(
        crossed, (row, np.searchsorted(node, x + (node[row] - y) * across / up)), 1
    )
    covered = crossed.cumsum(axis=1)[:, :-1] % 2 == 1
    # What is thinner than the raster is not lost.
    edges = begin + np.linspace(0.0, 1.0, 2 * NODES)[:, None, None] * (end - begin)
    x, y = np.rint((edges - node[0]) / (node[1] - node[0])).astype(int).reshape(-1, 2).T
    covered[y, x] = True
    return np.asarray(covered)
