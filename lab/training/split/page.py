"""The page docs/measured/split.md from what the judgement found."""

from __future__ import annotations

from typing import Any

from ros_pose_stats.core.estimators.split import FORGOTTEN, HOLDING
from ros_pose_stats.core.kernels.features.split_features import FAR, NEAR, SHALLOWEST
from ros_pose_stats.core.resting.poses import CORNER_REACHES

from .counting import (
    BODIES,
    FIT_DROPS,
    HIGHEST_DROP,
    HIGHEST_RESTITUTION,
    JUDGE_DROPS,
    LOWEST_DROP,
)
from .fit import BATCH
from .judge import ALL, EPOCHS, FOLDS, STARTS, UNITS, Score
from .real_parts import DROPS as PART_DROPS, PartScore
from .samples import HEIGHT, LOW

Found = dict[str, Any]

HEADER = (
    "bodies",
    "height, radii",
    "split",
    "at 0.2",
    "at 0.5",
    "at 0.8",
    "combined",
    "at 0.2",
    "at 0.5",
    "at 0.8",
    "ratio",
    "expected",
    "largest",
    "combined's",
    "1 in 1000",
    "combined's",
)

PART_HEADER = (
    "part",
    "poses",
    "height, radii",
    "split",
    "combined",
    "expected",
    "largest",
    "combined's",
)

AIMS = (
    (ALL, HEIGHT, 1.4),
    (ALL, LOW, 1.7),
    ("rounds", HEIGHT, 2.0),
    ("stepped", HEIGHT, 2.0),
    ("hollow", HEIGHT, 2.0),
)
AIMED = """### What was aimed at

All families pooled over the restitutions, and turned ones at the worst of them. Where an aim is
not met, the expected error says so of the part, and drops are the answer (`auto` with a target
error)."""

PARTS = """### Demo parts

The parts of the command `shapes`, as a designer draws them, {drops} drops at each of the three
restitutions; `python -m lab.training.split parts FILE ...` prints the same of one's own.
"""

SAID = {
    "new bodies": "Bodies that the fit never saw; of fine ellipsoids (100 to 2000 points) it saw "
    "none at all.",
    "folds by body": f"Fits to {FOLDS - 1} of {FOLDS} bodies, judged on the others.",
    "families held out": "Fits without any body of the family that is judged.",
}


def plain(scores: dict[str, list[Score]], machine: dict[str, str]) -> Found:
    """Plain values for JSON."""
    return {
        "machine": machine,
        "scores": {
            name: [one._asdict() for one in some] for name, some in scores.items()
        },
    }


def page(found: Found) -> str:
    """The page."""
    families = sum(fit > 0 for fit, _ in BODIES.values())
    reaches = " and ".join(f"{reach:g}" for reach in CORNER_REACHES.tolist())
    fit, judged = (sum(one[place] for one in BODIES.values()) for place in (0, 1))
    parts = [
        HEAD.format(
            bodies=fit,
            judged=judged,
            drops=FIT_DROPS,
            judge=JUDGE_DROPS,
            lowest=LOWEST_DROP,
            highest=HIGHEST_DROP,
            most=HIGHEST_RESTITUTION,
            left=UNITS[0],
            held=UNITS[1],
            epochs=EPOCHS,
            starts=STARTS,
            batch=BATCH,
            forgotten=FORGOTTEN,
            holding=HOLDING,
            families=families,
            reaches=reaches,
            shallowest=SHALLOWEST,
            near=NEAR,
            far=FAR,
        )
    ]
    for name, rows in found["scores"].items():
        parts.append(f"### {name.capitalize()}\n\n{SAID[name]}\n\n{_table(rows)}\n")
    parts.append(f"{AIMED}\n\n{_aims(found['scores']['new bodies'])}\n")
    parts.append(PARTS.format(drops=PART_DROPS) + f"\n{part_table(found['parts'])}\n")
    told = ", ".join(f"{key} {value}" for key, value in found["machine"].items())
    parts.append(f"Run on: {told}.\n")
    return "\n".join(parts)


def _aims(rows: list[Found]) -> str:
    """What was aimed at beside what came: all families pooled, turned ones at the worst."""
    lines = [
        "| new bodies | height, radii | aim | split | met |",
        "|---|---|---|---|---|",
    ]
    for what, height, aim in AIMS:
        (errors,) = (
            row["errors"]
            for row in rows
            if (row["what"], row["height"]) == (what, height)
        )
        worst = errors[0] if what == ALL else max(errors)
        lines.append(
            f"| {what} | {height:g} | {aim:g} | {worst:.2f} | "
            f"{'yes' if worst <= aim else 'no'} |"
        )
    return "\n".join(lines)


def plain_parts(scores: list[PartScore]) -> list[Found]:
    """Plain values for JSON."""
    return [one._asdict() for one in scores]


def part_table(rows: list[Found]) -> str:
    """Of `PartScore`s."""
    lines = ["| " + " | ".join(PART_HEADER) + " |", "|---" * len(PART_HEADER) + "|"]
    for row in rows:
        cells = [
            row["part"],
            f"{row['poses']}",
            f"{row['height']:g}",
            *(f"{row[name]:.2f}" for name in ("split", "combined", "expected")),
            *(f"{row[name]:.0f}" for name in ("largest", "combined_largest")),
        ]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _table(rows: list[Found]) -> str:
    lines = ["| " + " | ".join(HEADER) + " |", "|---" * len(HEADER) + "|"]
    for row in rows:
        cells = [
            row["what"],
            f"{row['height']:g}",
            *(f"{value:.2f}" for value in (*row["errors"], *row["combined"])),
            f"{row['errors'][0] / row['combined'][0]:.2f}",
            f"{row['expected']:.2f}",
            *(
                f"{row[name]:.0f}"
                for name in ("largest", "combined_largest", "tail", "combined_tail")
            ),
        ]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


HEAD = """# The split estimator

*This page is written by `python -m lab.training.split judge --write`.*

`split` knows restitution (0 to {most:g}), drop height ({lowest:g} to {highest:g} radii) and
inertia. It walks down the splitting graph like EAE and MEAE. Where those take the components of a
split in proportion to their solid angles, it takes them in proportion to weights:

    w(C, E) = area {{r < E}} exp f(x) + s held(C) exp h(x)
    f, h    = a + b x + sum_k c_k tanh(d_k x + e_k), each with coefficients of its own

with x the 26 inputs below. The first term is of parts that the last of their energy leaves in
the component, the second of those that are caught where they land: held is the solid angle of its
faces that hold a part, s = depth / (depth + {holding:g} E). Where a ridge is shallower than what
one impact takes, the second has a say. A component weighs w where it splits off, and where two
components join, their weights add and go on growing as the formula does for the joined one. So
poses that symmetry makes equal come out equal, and splits that tie give the same answer in any
order. What the sum is more or less than the formula's own weight of the joined one is forgotten
as that one grows: it has the share 1 / (1 + (g / {forgotten:g} d)^2), with g the rise of the level
since and d the depth of the shallower of the two. So a face that breaks in two along a low ridge
changes nothing at first, and a pose that ceases to be stable vanishes with its area and its depth.
With f = 0 and no second term this is MEAE to the last digits.

## Inputs

Of a component at the level E of the split:

1. log of the share of the sphere where r < E;
2. that of R < E over it, and 3. the log of the ratio: flat wide faces have little of it;
4. depth over level, (E - d) / E; 5. E; 6. d, the lowest height, all in radii;
7. the inertia about its resting directions, against the mean moment;
8. log of the solid angle of the faces that hold a part that lands on them: those that the foot
   of the centre of mass lies in or near, and those that hardly differ from the stable face;
9. log of the arcs over which the part rolls across its edges while R < E, each weighted by the
   turn of the impulse there, in the metric of the inertia; 10. the same in plain angles;
11. log of 4, from {shallowest:g} on;
12. and 13. log of the area with all that joins it at this level or later, over its own: what
   joins later counts by e^(-rise / {near:g}) and e^(-rise / {far:g}), in radii; 14. and 15. the
   same of 8. They tell whether a split comes alone or among others that one impact decides.

Of the body: 16. trace of the inertia over mass and squared radius, 17. and 18. its smallest and
largest share, 19. the highest split, 20. the lowest pose. Of the scene: 21. -log(1 - restitution),
22. log of the drop height in radii.

Of the corners: 23. and 24. log of how far the body turns in few of them, the sum over all pairs
of both angle defects over 4 pi times (1 - (distance / reach)^2)^2 up to a reach of {reaches}
radii. It tells a body of few sharp corners from a finely divided round one, and a corner cut off
by a hair or one more on a straight edge changes nothing.

Of the component again: 25. the share of facets of round and toothed surfaces in the solid angle of
its faces, and 26. the mean over that angle of the log of how many facets a turn has. A part rolls
on over them and loses little at each.

## The fit

{bodies} bodies of {families} families (`lab/training/families`), each dropped {drops}
times in six scenes: restitution 0.2, 0.5 and 0.8 from 20 radii, and three drawn from all
restitutions and heights, from {lowest:g} radii, where most bodies are released touching the plate.
Random polyhedra stand as in the paper, on every stable face; all others have the poses and the
round surfaces that parts have by default.
{left} hyperbolic tangents in f and {held} in h; the loss is the negative log likelihood of the
counts plus three times the square error, with a small ridge. Adam goes through all samples
{epochs} times, {batch} at a step. log w is the mean of {starts} such fits from different starts,
here and wherever bodies are held out. The counts are in
`lab/training/split/samples.npz`; `python -m lab.training.split drops` counts them anew,
`fit --write` fits. {judged} other bodies, {judge} drops in each scene, are for judging alone.

## What did not pay

Tried on held-out bodies and left out: the phase volume of a component and the flux of phase
volume into it by dissipation, as for a part that mixes well (far worse than the plain area: a
part that loses energy hardly mixes near a saddle); powers of the
kinetic energy along the arcs; the mean lever arm; areas at half the level; the toppled share of
QSE (as good as input 8, but it jumps); the whole solid angle of the faces; the fourth power of the
error in the loss, which hardly lowers the largest deviations. How densely the turns of a
component's arcs crowd, smoothed over some tenths of a radian, takes a few per cent off the error
of plates, machined and weighted parts, but needs a sum over all pairs of arcs, which costs more
than all the rest on a body of thousands of faces. It is not in.

## Errors

Root mean square over the poses in points, the drops' own noise taken off: pooled over the three
restitutions and at each, beside those of the paper's combined estimator. `expected` is the root
mean square of the errors that the shipped estimator expects of these parts. Then come
the largest deviation of a pose from its counted share, noise and all, and the one that one pose in
a thousand exceeds.
"""
