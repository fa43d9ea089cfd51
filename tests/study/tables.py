"""Datasets for several test files: those that come with the package, and synthetic ones."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from itertools import pairwise

import numpy as np

from ros_pose_stats.records import DropScene
from ros_pose_stats.study.dataset import Dataset, shipped_dataset
from ros_pose_stats.study.estimates import estimates, restings
from ros_pose_stats.study.table import table

PER_BODY = ("vertices", "triangles", "poses", "redraws", "center_of_mass", "settled")


def shipped(shift=0.0, moment="inertia"):
    """A reference dataset, read once."""
    return _shipped(shift, moment)


def compared(shift=0.0, moment="inertia"):
    """The table of a reference dataset, made once."""
    return _compared(shift, moment)


@lru_cache(maxsize=4)
def _shipped(shift, moment):
    return shipped_dataset(shift, moment)


@lru_cache(maxsize=4)
def _compared(shift, moment):
    return table(shipped(shift, moment), rerun=False)


def first_bodies(dataset, bodies):
    """The same dataset with its first bodies alone."""
    arrays, ends = dataset.arrays, {}
    for field, number in (("vertex", "vertices"), ("triangle", "triangles"), ("down", "poses"),
                          ("height", "poses"), ("count", "poses")):
        ends[field] = int(arrays[number][:bodies].sum())
    ends.update(dict.fromkeys(PER_BODY, bodies))
    return Dataset(replace(dataset.spec, bodies=bodies),
                   {name: values[:ends[name]] for name, values in arrays.items()})


@lru_cache(maxsize=4)
def some(bodies):
    """The first bodies of the reference dataset without shift."""
    return first_bodies(shipped(), bodies)


@lru_cache(maxsize=4)
def told(bodies):
    """Stable poses and every estimator's probabilities for `some`."""
    known = restings(some(bodies))
    return known, estimates(known, DropScene(cluster_tolerance=0.0))


def drawn(dataset, probability, drops, seed, restitutions=(0.2, 0.5, 0.8)):
    """The same bodies with counts drawn from probabilities (P,), independent drops."""
    spec = replace(dataset.spec, drops=drops, restitutions=restitutions)
    sizes = np.diff(spec.block_ends, prepend=0)
    random = np.random.default_rng(seed)
    starts = dataset.pose_starts
    counts = np.concatenate([
        np.moveaxis([[random.multinomial(size, probability[begin:end]) for size in sizes]
                     for _ in restitutions], 2, 0)
        for begin, end in pairwise(starts)]).astype(np.uint32)
    settled = np.broadcast_to(sizes, (spec.bodies, len(restitutions), len(sizes)))
    return Dataset(spec, {**dataset.arrays, "count": counts,
                          "settled": settled.astype(np.uint32)})


def mixed(dataset, one, other, share):
    """Probabilities (P,) between two estimators', and their true distance from the first."""
    probability = (1.0 - share) * one + share * other
    sums = np.bincount(dataset.body, probability)[dataset.body]
    probability = probability / sums
    return probability, float(np.sqrt(np.mean((probability - one) ** 2)))
