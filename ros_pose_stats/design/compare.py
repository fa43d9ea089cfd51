"""Variants of a part side by side: which poses correspond, and whether they differ."""

import secrets
import time
from collections.abc import Callable, Sequence
from dataclasses import replace

from ..errors import RequestError
from ..records import DropScene, Part, scene as scenes
from ..resting.poses import resting_poses
from ..simulation.request import drop_request
from ..statistics.feeding import check_wanted
from . import comparison, correspondence, describe, paired_drops, verdicts

FIRST_LOOK = 1250
"""Drops of each variant before the first look; each look has twice as many as the one before."""

MOST_DROPS = 20_000
"""Drops of each variant, if nothing ends them before: differences are known to a point then."""

MOST_VARIANTS = 26

LARGEST_RATIO = 9.0
"""Of two radii: beyond it lie those of a part in millimetres and in centimetres."""


def compare(parts: Sequence[Part], wanted: Sequence[int] = (), drops: int = MOST_DROPS,
            restitution: float = scenes.DEFAULT_RESTITUTION, seed: int | None = None,
            drop_height: float | None = None, workers: int | None = None,
            on_progress: Callable[[int, int], object] | None = None,
            should_stop: Callable[[], bool] | None = None, *,
            cluster_tolerance: float = scenes.DEFAULT_CLUSTER_TOLERANCE,
            round_sides: int = scenes.DEFAULT_ROUND_SIDES,
            plate_error: float = scenes.DEFAULT_PLATE_ERROR) -> comparison.Comparison:
    """Compare the first variant of a part with each of the others, dropped from the same starts.

    Drops end where each of the others is expected to differ on a plate, in the share that a
    feeder accepts if one is asked for; where all differences are known to a point (half of their
    90 % intervals); or at the most drops.

    Parameters
    ----------
    parts : sequence of Part
        2 to 26.
    wanted : sequence of int
        Poses of the first variant that a feeder accepts; none asks for no feeder.
    drops : int
        The most of each variant, 1 to 1e9.
    restitution : float
        Coefficient of restitution, 0 <= restitution < 1.
    seed : int, optional
        0 to 2^64 - 1; drop k of all variants depends on seed and k alone. Default: a fresh one.
    drop_height : float, optional
        Height of the centre of mass at release, metres, the same for all variants. Default: 20
        radii of the first one.
    workers : int, optional
        Threads; default: all cores.
    on_progress : callable, optional
        Takes the number of drops done, and the most of them, of all variants.
    should_stop : callable, optional
        After True the comparison ends with the drops done by then.
    cluster_tolerance, round_sides
        As for `simulate`.
    plate_error : float
        Of a single share on the plate, a fraction from 0 to 1.

    Returns
    -------
    Comparison
        The same for the same request, whatever the workers.

    Raises
    ------
    RequestError
        If there is one part only, or one is more than 9 times as large as the first or that as
        it, or there is no such pose, or a number is out of its range.
    MeshError
        If the hull of a part does not enclose its centre of mass.
    """
    begin = time.perf_counter()
    if not 2 <= len(parts) <= MOST_VARIANTS:
        raise RequestError(f"2 to {MOST_VARIANTS} variants to compare", f"{len(parts)}",
                           "give the files of the variants, the one to compare with first")
    if not 0.0 <= plate_error <= 1.0:
        raise RequestError("a plate error from 0 to 1, as a fraction", f"{plate_error}",
                           "0.05 is a plate that nobody has counted on")
    scene = DropScene(restitution, drop_height, cluster_tolerance, round_sides)
    asked = drop_request(drops, secrets.randbits(32) if seed is None else seed, 0.0, workers, None)
    resting = [resting_poses(part, cluster_tolerance, round_sides) for part in parts]
    _check_sizes([one.body.radius for one in resting])
    if wanted:
        check_wanted(wanted, len(resting[0].poses))
    matches = [correspondence.find_correspondence(resting[0], other) for other in resting[1:]]
    pairs = paired_drops.begin_pairs(parts, scene, asked.seed)
    turns = [None, *(match.turn for match in matches)]
    sizes = looks(asked.drops)
    for number, size in enumerate(sizes):
        pairs = paired_drops.drop_more(pairs, parts, size, turns, asked.workers,
                                       _progress(on_progress, pairs.drops * len(parts),
                                                 sizes[-1] * len(parts)), should_stop)
        found = verdicts.compare_pairs(parts, pairs, matches,
                                       tuple(dict.fromkeys(map(int, wanted))),
                                       sizes[number] / sum(sizes), plate_error)
        if pairs.drops < size or found.is_settled or found.half_width <= comparison.ONE_POINT:
            break
    return replace(found, seconds=time.perf_counter() - begin)


def _check_sizes(radii: Sequence[float]) -> None:
    """Refuse variants of another scale than the first one."""
    for place, radius in enumerate(radii):
        if max(radius, radii[0]) > LARGEST_RATIO * min(radius, radii[0]):
            raise RequestError(
                f"variants of one scale, radii at most {LARGEST_RATIO:g} times apart",
                f"A with a radius of {1e3 * radii[0]:.4g} mm and {describe.letter(place)} with "
                f"{1e3 * radius:.4g} mm", "export them in one unit")


def looks(drops: int) -> list[int]:
    """Numbers of drops at which the verdict is looked at, rising.

    A look has a share of the 5 % in proportion to its drops, so that all looks together are wrong
    in no more than 5 % (the sum of the chances bounds that of any of them).
    """
    sizes = [drops]
    while sizes[-1] >= 2 * FIRST_LOOK:
        sizes.append(sizes[-1] // 2)
    return sizes[::-1]


def _progress(on_progress: Callable[[int, int], object] | None, before: int, most: int
              ) -> Callable[[int, int], object] | None:
    """What takes the drops done since some, and gives all that are done on."""
    return None if on_progress is None else lambda done, _: on_progress(before + done, most)
