"""The chart of speed against accuracy: every method, simulation, and methods of others."""

from .run import PLANS, QUICK, ChartResults, Measured, Plan, chart
from .text import chart_text

__all__ = ["PLANS", "QUICK", "ChartResults", "Measured", "Plan", "chart", "chart_text"]
