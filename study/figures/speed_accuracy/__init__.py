"""The chart of speed against accuracy: points, panels, figure and Pareto front."""

from .figure import SUBTITLE, speed_accuracy_figure
from .points import ChartPanel, ChartPoint, pareto_front

__all__ = [
    "SUBTITLE",
    "ChartPanel",
    "ChartPoint",
    "pareto_front",
    "speed_accuracy_figure",
]
