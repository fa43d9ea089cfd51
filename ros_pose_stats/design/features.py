"""What of a part can be changed: centre of mass, proportions, resting faces."""

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ..resting.poses import RestingPoses

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Kind = Literal["centre", "stretch", "face"]

KINDS = ("centre", "stretch", "face")
CENTRE, STRETCH, FACE = range(3)

AXES = "xyz"


@dataclass(frozen=True, eq=False)
class Feature:
    """One thing to be changed."""

    # `centre` (of mass, along an axis), `stretch` (along an axis) or `face` (the resting face of
    # a pose, outward)
    kind: Kind
    axis: int = -1  # of the first two kinds; else -1
    poses: tuple[int, ...] = ()  # that rest on the face
    # (k,); faces of the body that are moved
    planes: Index = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    # (3,); middle of the face, in radii about the centre of mass
    anchor: Array = field(default_factory=lambda: np.zeros(3))
    size: float = 0.0  # area of the face, in square radii

    @property
    def is_length(self) -> bool:
        """Whether its step is a length; else it is a fraction."""
        return self.kind != "stretch"


def find_features(resting: RestingPoses) -> tuple[Feature, ...]:
    """The centre of mass along x, y and z, stretching along x, y and z, then faces."""
    axes = [Feature(kind, axis) for kind in ("centre", "stretch") for axis in range(3)]
    return (*axes, *_faces(resting))


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
