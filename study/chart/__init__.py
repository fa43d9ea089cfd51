"""The chart of speed against accuracy: every method, simulation, and other software."""

from .speed_accuracy import (
    PLANS,
    QUICK,
    ChartResults,
    MeasuredSize,
    Plan,
    chart,
    chart_text,
)

__all__ = [
    "PLANS",
    "QUICK",
    "ChartResults",
    "MeasuredSize",
    "Plan",
    "chart",
    "chart_text",
]
