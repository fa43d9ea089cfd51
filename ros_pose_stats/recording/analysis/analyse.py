"""Bags analysed: results, jobs and camera counts of each part, set beside each other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .bag_contents import BagContents, PartRecord, Paths
from .bag_reader import read_bags
from .camera_counts import CameraCounts
from .comparisons import (
    CountComparison,
    SimulationComparison,
    count_comparison,
    incomparable,
    simulation_comparisons,
)
from .results import ResultHistory


@dataclass(frozen=True, eq=False)
class PartAnalysis:
    """One part.

    Attributes
    ----------
    record : PartRecord
    simulations : tuple of tuple of SimulationComparison
        Of each of the record's histories.
    counts : tuple of CountComparison
        One a plate, drop height and numbering.
    """

    record: PartRecord
    simulations: tuple[tuple[SimulationComparison, ...], ...]
    counts: tuple[CountComparison, ...]


@dataclass(frozen=True, eq=False)
class BagAnalysis:
    """All parts.

    Attributes
    ----------
    contents : BagContents
    parts : tuple of PartAnalysis
    strays : tuple of CountComparison
        Camera counts of parts that no result is about.
    """

    contents: BagContents
    parts: tuple[PartAnalysis, ...]
    strays: tuple[CountComparison, ...]


def analyse_bags(paths: Paths) -> BagAnalysis:
    """Read bags and compare estimates, simulations and camera counts in them.

    Parameters
    ----------
    paths : path or iterable of path
        Bag directories (of the node, or recorded by `ros2 bag record`), directories of many
        bags, or single files.

    Returns
    -------
    BagAnalysis
        Its `parts` hold numpy arrays in the order of each part's pose table.

    Raises
    ------
    BagError
        If there is no bag, a named file cannot be read, or no message of this package's types
        is in any of them.
    """
    return analyse(read_bags(paths))


def analyse(contents: BagContents) -> BagAnalysis:
    """The same for bags that have been read."""
    compared: dict[int, list[CountComparison]] = {}
    for counts in contents.counts:
        place, comparison = _compared(counts, contents.parts)
        compared.setdefault(place, []).append(comparison)
    parts = tuple(
        PartAnalysis(record, tuple(tuple(simulation_comparisons(history))
                                   for history in record.histories),
                     tuple(compared.get(place, ())))
        for place, record in enumerate(contents.parts))
    return BagAnalysis(contents, parts, tuple(compared.get(-1, ())))


def _compared(counts: CameraCounts,
              parts: tuple[PartRecord, ...]) -> tuple[int, CountComparison]:
    """Which part (-1: none) counts belong to, and what they are compared with."""
    fitting = _parts_of(counts, parts)
    if not fitting:
        return -1, incomparable(counts, "no result of this part is in the bags")
    place = fitting[0]
    digests = {parts[each].part_digest for each in fitting}
    if len(digests) > 1:
        return -1, incomparable(
            counts, f"the counts carry no digest, and {len(digests)} parts are called "
            f"{counts.part_id}")
    histories = parts[place].histories
    for history in histories:
        if np.isclose(history.cluster_tolerance, counts.cluster_tolerance, rtol=1e-9, atol=0.0):
            return place, _numbered(counts, history)
    known = ", ".join(f"{each.cluster_tolerance:g}" for each in histories) or "none"
    return place, incomparable(
        counts, f"counted at cluster tolerance {counts.cluster_tolerance:g}, results are at "
        f"{known}: the same index is not the same pose")


def _parts_of(counts: CameraCounts, parts: tuple[PartRecord, ...]) -> list[int]:
    """Parts with the counts' digest, or without one their name; the same name first."""
    fitting = [place for place, part in enumerate(parts) if (
        part.part_digest == counts.part_digest if counts.part_digest
        else part.part_id == counts.part_id)]
    return sorted(fitting, key=lambda place: (parts[place].part_id != counts.part_id,
                                              not parts[place].histories))


def _numbered(counts: CameraCounts, history: ResultHistory) -> CountComparison:
    unknown = counts.index[~np.isin(counts.index, history.poses.index)]
    if unknown.size:
        return incomparable(
            counts, f"pose {unknown[0]} was counted, which the part does not have: the poses are "
            "numbered differently")
    return count_comparison(counts, history)
