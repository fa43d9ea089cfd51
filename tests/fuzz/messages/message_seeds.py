"""Messages and requests as clients send them, and with hostile values in their fields."""

from __future__ import annotations

from array import array
from collections.abc import Callable
from random import Random
from typing import Any

import numpy as np
from geometry_msgs.msg import Inertia, Point, Pose, Quaternion, Vector3
from numpy.typing import NDArray
from ros_pose_stats_msgs import srv
from ros_pose_stats_msgs.action import SimulateDrops
from ros_pose_stats_msgs.msg import ObservedParts, PartMesh, PoseCounts
from shape_msgs.msg import Mesh, MeshTriangle

HOSTILE_NAMES = (
    "", ".", "..", "../../x", "../" * 40 + "etc/x", "/etc/x", "/tmp/x", "~/x", "..\\x", "C:\\x",
    "a\0b", "a\nb", "\x1b[31mred", "\r\nFATAL", "\u202egnp.exe", "\u200b", "\ufeff", "x" * 201,
    "y" * 5000, "%s%n%x", "$(touch x)", "`touch x`", "; touch x", "part/1", "*", "🗿", "a b",
    "{}", "{0}", "'", '"', "nul", "-rf", "part.mcap", ".lock", "metadata.yaml")

HOSTILE_NUMBERS = (
    float("nan"), float("inf"), -float("inf"), 0.0, -0.0, 5e-324, -5e-324, 1e-300, 1e-30, 1e30,
    1e160, 1.7976931348623157e308, -1.7976931348623157e308, -1.0, 1.0, 0.5, 1.0 - 2**-53)

HOSTILE_COUNTS = (0, 1, 2**31 - 1, 2**31, 2**32 - 1, 2**63 - 1, 2**63, 2**64 - 1)
METHODS = ("", "combined", "csae", "simulation", "nothing", *HOSTILE_NAMES)

Surface = tuple[NDArray[np.float64], NDArray[np.int64]]

WEDGE: Surface = (
    np.array([(0.0, 0.0, 0.0), (0.04, 0.0, 0.0), (0.0, 0.03, 0.0), (0.01, 0.01, 0.02)]),
    np.array([(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]))
"""A tetrahedron, in metres."""

HOSTILE = 0.3
"""Share of fields that get a hostile value."""


class Seeds:
    """Makes messages of which most fields are good.

    Parameters
    ----------
    chance : Random
    """

    def __init__(self, chance: Random) -> None:
        self.chance = chance

    def make(self, kind: type) -> Any:
        """A message or request of a type that the node takes."""
        return MAKERS[kind](self)

    def name(self) -> str:
        """A part_id."""
        if self.chance.random() < HOSTILE:
            return self.chance.choice(HOSTILE_NAMES)
        return f"part_{self.chance.randrange(8)}"

    def number(self, good: float) -> float:
        """A value, mostly the good one."""
        return self.chance.choice(HOSTILE_NUMBERS) if self.chance.random() < HOSTILE else good

    def count(self, good: int, bits: int = 64) -> int:
        """A whole number."""
        hostile = self.chance.random() < HOSTILE
        return self.chance.choice(HOSTILE_COUNTS) % 2**bits if hostile else good

    def stamp(self, message: Any) -> Any:
        """The message with a time, perhaps one that no clock shows."""
        message.header.stamp.sec = self.chance.choice((0, 1_700_000_000, -2**31, 2**31 - 1))
        message.header.stamp.nanosec = self.count(5, 32)
        message.header.frame_id = self.name().replace("\0", "")
        return message

    def surface(self) -> Surface:
        """Vertices and triangles of a solid of a size of its own, sometimes spoiled."""
        vertices, triangles = WEDGE
        vertices = vertices * self.chance.uniform(0.5, 2.0)
        triangles = triangles.copy()
        if self.chance.random() < HOSTILE:
            place = self.chance.randrange(4), self.chance.randrange(3)
            if self.chance.random() < 0.5:
                vertices[place] = self.chance.choice(HOSTILE_NUMBERS)
            else:
                triangles[place] = self.chance.choice(HOSTILE_COUNTS) % 2**32
        return vertices, triangles

    def mesh(self) -> Mesh:
        """A `shape_msgs/Mesh`."""
        vertices, triangles = self.surface()
        return Mesh(vertices=[Point(x=x, y=y, z=z) for x, y, z in vertices.tolist()],
                    triangles=[MeshTriangle(vertex_indices=row.astype(np.uint32))
                               for row in triangles])

    def part(self) -> PartMesh:
        """A `PartMesh`: flat, nested, both or neither."""
        made = self.stamp(PartMesh(part_id=self.name(), unit=self.number(1.0),
                                   restitution=self.number(-1.0), drop_height=self.number(-1.0)))
        form = self.chance.choice(("flat", "flat", "flat", "nested", "nested", "both", "none"))
        if form in ("nested", "both"):
            made.mesh = self.mesh()
        if form in ("flat", "both"):
            vertices, triangles = self.surface()
            made.vertices = array("d", vertices.tobytes())
            made.triangles = array("I", triangles.astype(np.uint32).tobytes())
        if self.chance.random() < HOSTILE:
            made.inertia = self.inertia()
        return made

    def inertia(self) -> Inertia:
        """Mass properties that are hardly ever those of the part."""
        center = Vector3(x=self.number(0.01), y=self.number(0.008), z=self.number(0.005))
        tensor = {name: self.number(good) for name, good in (
            ("ixx", 1e-5), ("ixy", 0.0), ("ixz", 0.0), ("iyy", 1e-5), ("iyz", 0.0),
            ("izz", 1e-5))}
        return Inertia(m=self.number(0.1), com=center, **tensor)

    def counts(self) -> PoseCounts:
        """What a camera counted, perhaps of poses that are none."""
        poses = self.chance.randrange(5)
        return self.stamp(PoseCounts(
            part_id=self.name(), part_digest=self.name(), plate=self.name(),
            cluster_tolerance=self.number(0.005), drop_height=self.number(-1.0),
            index=[self.count(k, 32) for k in range(poses)],
            count=[self.count(5) for _ in range(self.chance.choice((poses, poses, 2)))],
            unclassified=self.count(3)))

    def observed(self) -> ObservedParts:
        """What a camera saw, perhaps with orientations that are none."""
        parts = self.chance.randrange(5)
        made = self.stamp(ObservedParts(
            part_id=self.name(), poses=[self.pose() for _ in range(parts)],
            confidence=[self.number(0.9) for _ in range(self.chance.choice((0, parts, 2)))]))
        if self.chance.random() > HOSTILE:
            made.header.frame_id = self.chance.choice(("", "plate"))
        return made

    def pose(self) -> Pose:
        """A pose on the plate."""
        return Pose(position=Point(x=self.number(0.1), y=0.0, z=0.0),
                    orientation=Quaternion(x=self.number(0.6), y=0.0, z=0.0, w=0.8))

    def estimate(self) -> Any:
        """A request for an estimate."""
        return srv.EstimatePoses.Request(
            part_id=self.known(), part=self.carried(), method=self.chance.choice(METHODS),
            restitution=self.number(-1.0), drop_height=self.number(-1.0),
            target_error=self.number(0.0))

    def simulation(self, kind: type = srv.StartDropSimulation.Request) -> Any:
        """A request for a drop simulation, or a goal."""
        return kind(
            part_id=self.known(), part=self.carried(), drops=self.count(20),
            restitution=self.number(-1.0), drop_height=self.number(-1.0), seed=self.count(7),
            target_error=self.number(0.0), max_seconds=self.number(0.0))

    def known(self) -> str:
        """A part_id of a request, often none."""
        return self.name() if self.chance.random() < 0.5 else ""

    def carried(self) -> PartMesh:
        """A part of a request, often none."""
        return self.part() if self.chance.random() < 0.7 else PartMesh()


MAKERS: dict[type, Callable[[Seeds], Any]] = {
    PartMesh: Seeds.part, Mesh: Seeds.mesh, PoseCounts: Seeds.counts,
    ObservedParts: Seeds.observed,
    srv.EstimatePoses.Request: Seeds.estimate,
    srv.StartDropSimulation.Request: Seeds.simulation,
    SimulateDrops.Goal: lambda seeds: seeds.simulation(SimulateDrops.Goal),
    srv.GetStatistics.Request: lambda seeds: srv.GetStatistics.Request(part_id=seeds.name()),
    srv.ForgetPart.Request: lambda seeds: srv.ForgetPart.Request(part_id=seeds.name()),
    srv.GetDropSimulation.Request: lambda seeds: srv.GetDropSimulation.Request(
        job_id=seeds.name()),
    srv.CancelDropSimulation.Request: lambda seeds: srv.CancelDropSimulation.Request(
        job_id=seeds.name()),
}
"""How each is made."""
