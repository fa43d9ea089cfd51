"""Made-up data of the size and shape of the real ones."""

from __future__ import annotations

import numpy as np

from ros_pose_stats.plots.study.probabilities import Panel
from ros_pose_stats.plots.study.speed_accuracy import ChartPanel, ChartPoint

PARTS = 3171
DROPS = 100
ERRORS = {"area": 0.112, "CSAE": 0.085, "ADRE": 0.078, "QSE": 0.070, "PQSE": 0.072,
          "NQSE": 0.062, "EAE": 0.068, "MEAE": 0.040, "combined": 0.036}


def probabilities(parts=PARTS, seed=1):
    """Of 2 to 11 stable poses a part, one row."""
    rng = np.random.default_rng(seed)
    return np.concatenate([rng.dirichlet(np.full(poses, 1.2))
                           for poses in rng.integers(2, 12, size=parts)])


def counted(chances, seed=2):
    """Shares of `DROPS` drops."""
    return np.random.default_rng(seed).binomial(DROPS, chances) / DROPS


def panels(parts=PARTS):
    chances = probabilities(parts)
    simulated = counted(chances)
    rng = np.random.default_rng(3)
    found = []
    for title, error in ERRORS.items():
        estimated = np.clip(chances + rng.normal(scale=error, size=len(chances)), 0.0, 1.0)
        x = np.linspace(0.0, 1.0, 101)
        curve = (x, x + x * (1 - x) * (-0.874 + 8.03 * x - 16.3 * x**2 + 7.7 * x**3))
        found.append(Panel(title, estimated, simulated, error,
                           float(np.abs(estimated - simulated).max()),
                           curve if title == "QSE" else None))
    return found


PAPER_SIZE = {"area": (0.20, 11.0), "CSAE": (0.21, 8.7), "ADRE": (0.22, 7.7), "QSE": (0.27, 7.4),
              "PQSE": (0.31, 7.2), "NQSE": (0.28, 6.5), "EAE": (0.36, 6.4), "MEAE": (0.33, 3.1),
              "combined": (0.40, 3.0)}
"""Milliseconds and percentage points of each estimator."""


def chart_panels():
    """Three sizes of part with all that is measured on them."""
    return [ChartPanel("paper-size, 9 vertices", chart_points(1.0, 1.0)),
            ChartPanel("200 vertices", chart_points(7.0, 0.8)),
            ChartPanel("2 000 vertices", chart_points(45.0, 0.65))]


def chart_points(slower, better):
    found = [point(name, "paper", 1e-3 * slower * time, 0.01 * better * error, 0.06)
             for name, (time, error) in PAPER_SIZE.items()]
    found.append(point("split", "estimator", 0.42e-3 * slower, 0.023 * better, 0.06))
    for drops, time, error in ((10, 0.002, 0.0225), (100, 0.0085, 0.018), (1000, 0.081, 0.0088)):
        found.append(point(f"n = {drops:,}".replace(",", " "), "hybrid", time * slower**0.5,
                           error * better, 0.06, "hybrid"))
    for drops, time in ((10, 0.0015), (100, 0.008), (1000, 0.08), (10_000, 0.8)):
        error = 0.316 * better / np.sqrt(drops)
        found.append(point(f"n = {drops:,}".replace(",", " "), "simulation",
                           time * slower**0.5, error, 0.05 if drops < 5000 else 1.2,
                           "drop simulation"))
    found.append(point("trimesh.poses", "outside", 0.005 * slower, 0.087 * better, 0.08))
    for drops, time, error in ((10, 0.2, 0.11), (100, 2.0, 0.04)):
        found.append(point(f"n = {drops}", "outside", time * slower**0.3, error * better, 0.1,
                           "MuJoCo"))
    return found


def point(name, kind, seconds, error, spread, series=None):
    return ChartPoint(name, kind, seconds, error, error * (1 - spread), error * (1 + spread),
                      series)
