"""The chart of speed against accuracy: points, panels, figure and Pareto front."""

from .figure import SUBTITLE, speed_accuracy_figure
from .front import pareto_front
from .points import ChartPanel, ChartPoint

__all__ = ["SUBTITLE", "ChartPanel", "ChartPoint", "pareto_front", "speed_accuracy_figure"]
