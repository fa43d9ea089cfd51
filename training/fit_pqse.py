"""Fits the redistributed share of PQSE to dice that were rolled.

    .venv/bin/python -m training.fit_pqse

The redistribution rule of the perturbed quasi-static estimator is this project's reading,
so its one number is fitted: by weighted least squares to Budden's 15 dice cut from square
bar (1980; table in Mungan and Lipscombe, Mathematical Gazette 97, 2013, note 97.16).
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import minimize_scalar

from ros_pose_stats import part_from_mesh, resting_poses
from ros_pose_stats.estimators.quasi_static import perturbed_quasi_static
from ros_pose_stats.resting.poses import RestingPoses
from ros_pose_stats.shapes import box
from ros_pose_stats.study.prisms.dice import DICE


def square_faces(resting: RestingPoses, share: float) -> float:
    """Probability of the two square faces of a bar along z."""
    probability = perturbed_quasi_static(resting, share)
    return float(sum(probability[pose.index] for pose in resting.poses
                     if abs(pose.down[2]) > 0.9))


def main() -> None:
    """Fit and print."""
    bars = [resting_poses(part_from_mesh(*box(1.0, 1.0, die.ratio)), 0.0) for die in DICE]
    observed = np.array([die.on_squares for die in DICE])
    rolls = np.array([die.rolls for die in DICE], dtype=np.float64)

    def predicted(share: float) -> np.ndarray:
        return np.array([square_faces(bar, share) for bar in bars])

    def misfit(share: float) -> float:
        return float((rolls * (predicted(share) - observed) ** 2).sum() / rolls.sum())

    best = minimize_scalar(misfit, bounds=(0.0, 2.0), method="bounded").x
    print("share   rms   (rms weighted by rolls)")
    for share in (0.0, best):
        rms = np.sqrt(((predicted(share) - observed) ** 2).mean())
        print(f"{share:5.3f}  {rms:6.4f}  {np.sqrt(misfit(share)):6.4f}"
              f"  {'QSE' if share == 0.0 else 'PQSE, fitted'}")
    noise = np.sqrt((observed * (1.0 - observed) / rolls).mean())
    print(f"sampling noise of the table {noise:.4f}")


if __name__ == "__main__":
    main()
