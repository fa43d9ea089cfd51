"""What of a part can be changed: centre of mass, proportions, resting faces, edges of the hull."""

import math
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from ..mesh.vectors import lengths
from ..resting.convex_body import ConvexBody
from ..resting.poses import RestingPoses

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Kind = Literal["centre", "stretch", "face", "edge"]

KINDS = ("centre", "stretch", "face", "edge")
CENTRE, STRETCH, FACE, EDGE = range(4)

AXES = "xyz"

SHARP = math.radians(20.0)
"""An edge where faces turn by less is part of a curved surface, and no edge to chamfer."""

ROUNDED = math.radians(150.0)
"""Facets about an axis that turn by less in all are a rounded edge; else they are a round part."""

SMALL = 0.03
"""Area, in square radii, below which a face is a facet of a curved surface, if it is smooth."""

FLAT = 0.02
"""Sine by which the normals of a rounded edge may lie off a plane."""

SHORTEST = 0.1
"""Length of an edge, in radii, below which it is none to be chamfered."""

MOST_EDGES = 200
"""Edges that are looked at, the most prominent ones."""


@dataclass(frozen=True, eq=False)
class Feature:
    """One thing to be changed."""

    # `centre` (of mass, along an axis), `stretch` (along an axis), `face` (the resting face of a
    # pose, outward) or `edge` (chamfered)
    kind: Kind
    axis: int = -1  # of the first two kinds; else -1
    poses: tuple[int, ...] = ()  # that rest on the face
    # (k,); faces of the body that are moved; of a rounded edge its facets
    planes: Index = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    # (k, 2); faces of the body between which the edge is cut, each by a plane of its own
    pairs: Index = field(default_factory=lambda: np.zeros((0, 2), dtype=np.int64))
    # (3,); middle of the face or the edge, in radii about the centre of mass
    anchor: Array = field(default_factory=lambda: np.zeros(3))
    size: float = 0.0  # area of the face or length of the edge, in radii
    # (k, 2); hull points that the sides of the edge join; none of a rounded one
    ends: Index = field(default_factory=lambda: np.zeros((0, 2), dtype=np.int64))

    @property
    def is_length(self) -> bool:
        """Whether its step is a length; else it is a fraction."""
        return self.kind != "stretch"

    @property
    def is_rounded(self) -> bool:
        """Whether it is an edge that the part has rounded."""
        return self.kind == "edge" and bool(self.planes.size)

    @property
    def only_forward(self) -> bool:
        """Whether it can be changed one way only: an edge is cut, not built up."""
        return self.kind == "edge"


def find_features(resting: RestingPoses) -> tuple[Feature, ...]:
    """All that can be changed on a part.

    Returns the centre of mass along x, y and z, stretching along x, y and z, then faces, then
    edges, the longest first.
    """
    axes = [Feature(kind, axis) for kind in ("centre", "stretch") for axis in range(3)]
    return (*axes, *_faces(resting), *_edges(resting.body))


def pose_of_faces(resting: RestingPoses) -> tuple[Index, NDArray[np.bool_]]:
    """Pose (F,) that each face descends to, and whether the face is one that the pose rests on.

    Facets of a surface that the part rolls on are one with the stable facets of it.
    """
    found, body = resting.equilibria, resting.body
    pose = resting.clusters.pose[found.rank[found.arrays.basin]]
    rests = np.zeros(body.faces, dtype=np.bool_)
    rests[found.faces] = True
    strip = body.run_of_face
    rolled = np.unique(strip[found.faces][strip[found.faces] >= 0])
    return np.asarray(pose), rests | np.isin(strip, rolled)


def _faces(resting: RestingPoses) -> list[Feature]:
    """The faces that the part rests on, one feature a pose; poses on one surface share theirs."""
    found, body, grouped = resting.equilibria, resting.body, resting.clusters
    features: dict[tuple[int, ...], Feature] = {}
    for pose, lowest in enumerate(grouped.lowest.tolist()):
        face = int(found.faces[lowest])
        members = found.faces[(grouped.pose == pose) & grouped.near]
        strips = np.unique(body.run_of_face[members])
        moved = np.union1d(members, np.flatnonzero(np.isin(body.run_of_face, strips[strips >= 0])))
        key = tuple(moved.tolist())
        before = features[key].poses if key in features else ()
        features[key] = Feature("face", poses=(*before, pose), planes=moved,
                                anchor=body.polygon(face).mean(axis=0),
                                size=float(body.arrays.area[moved].sum()))
    return list(features.values())


def _edges(body: ConvexBody) -> list[Feature]:
    """Sharp edges, those between two surfaces together, and rounded edges."""
    ends, faces = body.edges
    turn = _turns(body, faces)
    surface = _surfaces(body, faces, turn)
    label = np.sort(surface[faces], axis=1)
    sharp = (turn >= SHARP) & (label[:, 0] != label[:, 1])
    features = []
    for mine in _together(label[sharp], np.flatnonzero(sharp)):
        first, last = body.points[ends[mine, 0]], body.points[ends[mine, 1]]
        length = lengths(last - first)
        middle = (0.5 * (first + last) * length[:, None]).sum(axis=0) / length.sum()
        features.append(Feature("edge", pairs=faces[mine], anchor=middle,
                                size=float(length.sum()), ends=ends[mine]))
    inner = np.flatnonzero(label[:, 0] == label[:, 1])
    for mine in _together(label[inner], inner):
        features += _rounded_edge(body, faces[mine])
    features = [one for one in features if one.size >= SHORTEST]
    features.sort(key=lambda one: -one.size)
    return features[:MOST_EDGES]


def _surfaces(body: ConvexBody, faces: Index, turn: Array) -> Index:
    """Number (F,) of the curved surface that a facet belongs to; a plane face is one by itself.

    Small facets that go on into each other smoothly are one, and those of a strip.
    """
    small, strip = body.arrays.area < SMALL, body.run_of_face
    smooth = faces[(turn < SHARP) & small[faces].all(axis=1)]
    # A strip is tied together at its first facet.
    first = np.arange(body.faces)
    rolls = np.flatnonzero(strip >= 0)
    if rolls.size:
        first[rolls] = np.unique(strip[rolls], return_index=True)[1][
            np.unique(strip[rolls], return_inverse=True)[1]]
        first[rolls] = rolls[first[rolls]]
    pairs = np.concatenate((smooth, np.stack((np.arange(body.faces), first), axis=1)))
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])),
                      shape=(body.faces, body.faces))
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)


def _together(label: Index, edges: Index) -> list[Index]:
    """Edges in groups of equal labels."""
    if not len(edges):
        return []
    _, group = np.unique(label, axis=0, return_inverse=True)
    return [edges[group.ravel() == number] for number in range(int(group.max()) + 1)]


def _rounded_edge(body: ConvexBody, inner: Index) -> list[Feature]:
    """The edge that facets (k, 2) round off, where they turn about one axis and not too far."""
    facets, uses = np.unique(inner, return_counts=True)
    normals = body.arrays.normal[facets]
    # About an axis the normals lie in a plane; of a rounded corner or a cone they do not.
    off_plane = math.sqrt(max(np.linalg.eigvalsh(normals.T @ normals)[0], 0.0) / len(facets))
    outer = facets[uses == 1]
    if off_plane > FLAT or len(outer) != 2:
        return []
    turn = float(_turns(body, outer[None, :])[0])
    if not SHARP <= turn <= ROUNDED or float(_turns(body, inner).sum()) > ROUNDED:
        return []
    corners = np.concatenate([body.polygon(face) for face in facets.tolist()])
    return [Feature("edge", planes=facets, pairs=outer[None, :], anchor=corners.mean(axis=0),
                    size=float(lengths(corners - corners.mean(axis=0)).max()) * 2.0)]


def _turns(body: ConvexBody, faces: Index) -> Array:
    """Angle (E,) by which the normal turns from one face to the other."""
    one, other = body.arrays.normal[faces[:, 0]], body.arrays.normal[faces[:, 1]]
    return np.asarray(np.arctan2(np.linalg.norm(np.cross(one, other), axis=1),
                                 (one * other).sum(axis=1)))
