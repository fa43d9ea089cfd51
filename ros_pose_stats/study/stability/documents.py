"""Writes the stability study: a page, a figure a walk, and the numbers."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ...plots.files import save_figure
from ...whole_files import write_json, write_whole
from .figure import draw_reliability, draw_walk
from .run import Curve, StabilityResults, WalkResults
from .text import stability_page

PAGE = Path("study") / "stability.md"


def write_stability(found: StabilityResults, folder: Path) -> list[Path]:
    """Write `study/stability.md`, `figures/stability_*` and `benchmarks/stability.json`.

    Parameters
    ----------
    found : StabilityResults
    folder : Path
        Created where it does not exist; other files in it stay.

    Returns
    -------
    list of Path
        What was written.
    """
    def write(aside: Path) -> None:
        for one in found.walks:
            save_figure(draw_walk(one), aside / "figures" / f"stability_{one.walk.name}")
        save_figure(draw_reliability(found), aside / "figures" / "stability_reliability")
        write_json(aside / "benchmarks" / "stability.json", as_dict(found))
        (aside / PAGE).parent.mkdir()
        (aside / PAGE).write_text(stability_page(found), encoding="utf-8")

    return write_whole(folder, write)


def as_dict(found: StabilityResults) -> dict[str, Any]:
    """Plain values for JSON."""
    return {"walks": [_walk(one) for one in found.walks],
            "reliability": {name: [one._asdict() for one in bins]
                            for name, bins in found.reliability.items()}}


def _walk(one: WalkResults) -> dict[str, Any]:
    return {
        "name": one.walk.name, "title": one.walk.title, "parameter": one.walk.parameter,
        "logarithmic": one.walk.logarithmic, "watched": one.walk.quantity,
        "cluster_tolerance": one.walk.cluster_tolerance, "values": one.values.tolist(),
        "poses": one.poses.tolist(), "methods": [_method(one, curve) for curve in one.curves],
        "simulation": {"probability": one.simulated.values.tolist(),
                       "low": one.simulated.low.tolist(), "high": one.simulated.high.tolist(),
                       "settled": one.simulated.settled.tolist()}}


def _method(found: WalkResults, one: Curve) -> dict[str, Any]:
    return {"method": one.method, "probability": one.values.tolist(), "slope": one.change.slope,
            "slope_at": found.walk.value(one.change.slope_at),
            "jumps": [{"at": found.walk.value(jump.place), "size": jump.size}
                      for jump in one.change.jumps]}
