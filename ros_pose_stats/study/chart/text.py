"""The numbers behind the chart, for people."""

from __future__ import annotations

from ..markdown import markdown_table, points
from .run import ChartResults, Measured


def chart_text(found: ChartResults) -> str:
    """A table for each size of part; methods that nothing beats are marked."""
    return "\n\n".join(_size(one) for one in found.sizes)


def _size(one: Measured) -> str:
    front = set(one.front())
    rows = []
    for k, point in sorted(enumerate(one.points), key=lambda entry: entry[1].seconds):
        name = f"{point.series}, {point.name}" if point.series else point.name
        rows.append((name, duration(point.seconds), points(point.error, 2),
                     f"{points(max(point.low, 0.0), 2)} to {points(point.high, 2)}",
                     "yes" if k in front else ""))
    head = ("method", "time a part", "error, points", "95 % interval", "on the front")
    return (f"### {one.title}\n\n{one.bodies} bodies with {one.mean_poses:.1f} stable poses on "
            f"average, {one.reference_drops} reference drops of each at each restitution.\n\n"
            + markdown_table(head, rows))


def duration(seconds: float) -> str:
    """Three digits in the unit that fits."""
    for unit, size in (("µs", 1e-6), ("ms", 1e-3)):
        if seconds < 1000.0 * size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds:.3g} s"
