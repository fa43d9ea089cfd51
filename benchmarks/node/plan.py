"""How much of the node is measured."""

from __future__ import annotations

from dataclasses import dataclass

from ..timing import Pace

MESHES_EACH, PLAIN, DISK = Pace(60, 2.0), Pace(5, 4.0), Pace(300, 2.0)
CALLS, LIMITS, RATES = Pace(100, 6.0), Pace(40, 3.0), Pace(5, 8.0)


@dataclass(frozen=True)
class Plan:
    """How much to measure.

    Attributes
    ----------
    starts : int
        Of the node and of the bare process.
    triangles : tuple of int
        Of the meshes that are estimated, rising.
    meshes, ordinary, disk, services, rates : Pace
    carried : int
        Triangles of the part that requests carry.
    many : int
        Vertices of the part with many poses.
    jobs : int
        To be known; the node keeps 1000.
    limits : Pace
    cancels : int
        For each part and way.
    feedback_seconds : float
    drops : int
        Of a job beside the library.
    """

    starts: int = 3
    triangles: tuple[int, ...] = (1000, 10_000, 100_000)
    meshes: Pace = MESHES_EACH
    ordinary: Pace = PLAIN
    disk: Pace = DISK
    services: Pace = CALLS
    carried: int = 10_000
    many: int = 4000
    jobs: int = 900
    limits: Pace = LIMITS
    cancels: int = 25
    feedback_seconds: float = 3.0
    drops: int = 40_000
    rates: Pace = RATES


QUICK = Plan(starts=1, triangles=(1000, 10_000), meshes=Pace(10, 0.5), ordinary=Pace(2, 2.0),
             disk=Pace(50, 0.5), services=Pace(12, 1.0), many=500,
             jobs=50, limits=Pace(5, 0.5), cancels=3, feedback_seconds=1.0,
             drops=10_000, rates=Pace(2, 2.0))
