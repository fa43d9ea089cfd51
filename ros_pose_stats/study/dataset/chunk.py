"""A piece of a dataset: some bodies and what became of their drops.

The same function runs in a thread here and on a cluster's workers.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ...records import DropScene
from ...shapes.random_polyhedra import RandomPolyhedron, random_polyhedron
from ...simulation.drop_body import PreparedBody, drop_body
from ...simulation.drops import drop_rules, run
from ...simulation.starts import random_starts
from .fields import Arrays
from .spec import DatasetSpec

AT_ONCE = 1000
"""Drops in one call of the kernel, which nothing can interrupt: about half a second."""


class Stopped(Exception):  # noqa: N818 - no error
    """A piece was given up because somebody asked for it."""


def make_chunk(spec: DatasetSpec, first: int, count: int,
               should_stop: Callable[[], bool] = lambda: False) -> Arrays:
    """Draw bodies and drop them.

    Parameters
    ----------
    spec : DatasetSpec
    first, count : int
        Bodies first ... first + count - 1.
    should_stop : callable, optional
        Asked about every half a second.

    Returns
    -------
    dict of arrays
        The fields of `fields.FIELDS` for these bodies alone. They depend on the arguments
        and on nothing else, whoever computes them.

    Raises
    ------
    Stopped
        If `should_stop` says so.
    """
    bodies = [random_polyhedron(spec.seed, number, spec.shift, spec.shift_moment)
              for number in range(first, first + count)]
    prepared = [drop_body(body.part(), 0.0) for body in bodies]
    counts = [_counts(spec, first + k, one, should_stop) for k, one in enumerate(prepared)]
    poses = [pose for one in prepared for pose in one.resting.poses]
    return {
        **_surfaces(bodies),
        "redraws": np.array([body.redraws for body in bodies], dtype=np.uint32),
        "poses": np.array([len(one.resting.poses) for one in prepared], dtype=np.uint32),
        "down": np.array([pose.down for pose in poses]),
        "height": np.array([pose.height for pose in poses]),
        "count": np.concatenate(counts).astype(np.uint32),
        "settled": np.stack([one.sum(axis=0) for one in counts]).astype(np.uint32),
    }


def _surfaces(bodies: list[RandomPolyhedron]) -> Arrays:
    return {
        "vertices": np.array([len(body.vertices) for body in bodies], dtype=np.uint32),
        "triangles": np.array([len(body.triangles) for body in bodies], dtype=np.uint32),
        "vertex": np.concatenate([body.vertices for body in bodies]),
        "triangle": np.concatenate([body.triangles for body in bodies]).astype(np.uint32),
        "center_of_mass": np.array([body.center_of_mass for body in bodies]),
    }


def _counts(spec: DatasetSpec, number: int, body: PreparedBody,
            should_stop: Callable[[], bool]) -> NDArray[np.int64]:
    """Drops in each pose, at each restitution, in each block (P, R, K)."""
    ends = spec.block_ends
    shape = len(body.resting.poses), len(spec.restitutions), len(ends)
    counts = np.zeros(shape, dtype=np.int64)
    for k, restitution in enumerate(spec.restitutions):
        rules = drop_rules(DropScene(restitution, spec.drop_height, 0.0), body.radius)
        seed = spec.drop_seed(number, restitution)
        for start in range(0, spec.drops, AT_ONCE):
            if should_stop():
                raise Stopped
            starts = random_starts(seed, start, min(AT_ONCE, spec.drops - start))
            pose = run(body, rules, starts).pose
            block = (start + np.arange(len(pose))) // spec.block
            settled = pose >= 0
            np.add.at(counts[:, k], (pose[settled], block[settled]), 1)
    return counts
